//! A claim as a finding of the answer.

use slipstream_bus::RobotModel;
use slipstream_sim::effects::find;

use super::claim::{Claim, Law};
use crate::answer::statement::statement;
use crate::answer::{Evidence, Finding, ParameterEstimate, Place, Unexplained};

/// The finding of a claim about `robot`; `runs` are the names of all runs, `span_s` when the recording
/// begins and ends.
pub(crate) fn finding(
    claim: &Claim,
    robot: &str,
    runs: &[String],
    model: &RobotModel,
    span_s: [f64; 2],
) -> Finding {
    let info = find(claim.effect);
    let unit = |name: &str| {
        let own = info.and_then(|info| info.parameter(name));
        own.map_or("1", |parameter| parameter.unit).to_owned()
    };
    let mut parameters: Vec<ParameterEstimate> = claim
        .values
        .iter()
        .map(|value| {
            let nominal = claim.nominal(model, value.name);
            ParameterEstimate {
                name: value.name.to_owned(),
                unit: unit(value.name),
                nominal,
                nominal_ci95: None,
                estimate: Some(value.estimate(nominal)),
                ci95: Some(value.interval(nominal)),
                text: None,
            }
        })
        .collect();
    if let Some((name, word)) = claim.word {
        parameters.push(ParameterEstimate::word(name, word));
    }
    let known = parameters.iter().any(|p| p.nominal.is_some());
    let of_runs = claim.runs.as_ref().map(|own| {
        own.iter()
            .filter_map(|run| runs.get(*run).cloned())
            .collect()
    });
    if let Some(law) = &claim.law {
        return outside(claim, law, robot, span_s);
    }
    let mut finding = Finding {
        robot: robot.to_owned(),
        effect: claim.effect.to_owned(),
        statement: String::new(),
        parameters,
        place: Place {
            channel: info
                .and_then(|info| info.channels.first())
                .map_or("longitudinal", |channel| channel.name())
                .to_owned(),
            intervals_s: vec![span_s],
            condition: info.map_or("always", |info| info.condition).to_owned(),
        },
        runs: of_runs,
        confused_with: claim.confused.iter().map(|id| (*id).to_owned()).collect(),
        evidence: Evidence {
            log_likelihood_gain: claim.gain,
            p_value: claim.p_value,
        },
        shape: None,
        driver: None,
        actions: Vec::new(),
    };
    let summary = info.map_or(claim.effect, |info| info.summary);
    finding.statement = statement(&finding, summary, span_s, known);
    finding
}

/// The finding of what the catalogue does not have.
fn outside(claim: &Claim, law: &Law, robot: &str, span_s: [f64; 2]) -> Finding {
    let what = Unexplained {
        robot: robot.to_owned(),
        channel: match law.table.acts_on {
            "turn_rate" => "yaw".to_owned(),
            _ => "longitudinal".to_owned(),
        },
        driver: law.table.driver.to_owned(),
        intervals_s: vec![span_s],
        shape: law.shape(),
    };
    let evidence = Evidence {
        log_likelihood_gain: claim.gain,
        p_value: claim.p_value,
    };
    what.finding(format!("follows {}", law.table.driver), evidence)
}
