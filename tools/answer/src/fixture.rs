//! Findings for tests.

use super::{Evidence, Finding, ParameterEstimate, Place};

/// A finding with these parameters: name, estimate, half width of its interval.
pub(crate) fn finding(effect: &str, parameters: &[(&str, f64, f64)]) -> Finding {
    let parameters = parameters
        .iter()
        .map(|&(name, value, half)| ParameterEstimate {
            name: name.to_owned(),
            unit: "1".to_owned(),
            nominal: None,
            nominal_ci95: None,
            estimate: Some(value),
            ci95: Some([value - half, value + half]),
            text: None,
        });
    Finding {
        robot: "r1".to_owned(),
        effect: effect.to_owned(),
        statement: String::new(),
        parameters: parameters.collect(),
        place: Place {
            channel: "longitudinal".to_owned(),
            intervals_s: Vec::new(),
            condition: "always".to_owned(),
        },
        runs: None,
        confused_with: Vec::new(),
        evidence: Evidence {
            log_likelihood_gain: 20.0,
            p_value: 1e-9,
        },
        shape: None,
        driver: None,
        actions: Vec::new(),
    }
}
