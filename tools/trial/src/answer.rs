//! The answer of a diagnosis (its JSON), as far as a trial grades it.

use serde::Deserialize;

use crate::label::DiagnosisVerdict;

/// The answer.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct DiagnosisAnswer {
    /// Overall result.
    pub verdict: DiagnosisVerdict,
    /// Effects missing in the model.
    #[serde(default)]
    pub findings: Vec<ReportedFinding>,
    /// Prediction error over 5 s.
    #[serde(default)]
    pub held_out: Option<ReportedPrediction>,
    /// Where the error went, for position and heading of each robot.
    #[serde(default)]
    pub budget: Vec<ReportedBudget>,
    /// From which size on what was not found would have been.
    #[serde(default)]
    pub detectable: Vec<ReportedLimit>,
}

/// Root mean square error over the horizon, of one robot in one unit.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ReportedBudget {
    /// With the nominal model.
    pub before: f64,
    /// With the findings.
    pub after: f64,
}

/// From which size on a parameter would have been found.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ReportedLimit {
    /// Id of the effect.
    pub effect: String,
    /// Its parameter.
    pub parameter: String,
    /// The smallest size; null where it cannot be found at any.
    pub smallest: Option<f64>,
}

/// One reported effect, or `unknown`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ReportedFinding {
    /// The robot.
    pub robot: String,
    /// Id of the effect.
    pub effect: String,
    /// Its parameters.
    #[serde(default)]
    pub parameters: Vec<ReportedParameter>,
    /// Where and when it shows.
    #[serde(rename = "where")]
    pub location: ReportedLocation,
    /// Effects that the answer declares indistinguishable from it.
    #[serde(default)]
    pub confused_with: Vec<String>,
    /// Runs of one machine for which it holds; all without it.
    #[serde(default)]
    pub runs: Option<Vec<String>>,
    /// The variable that an `unknown` effect depends on.
    #[serde(default)]
    pub driver: Option<String>,
}

/// A parameter: a number with its interval, or a text.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ReportedParameter {
    /// Its name.
    pub name: String,
    /// What the model says, or what it was before; null where it was not there.
    #[serde(default)]
    pub nominal: Option<f64>,
    /// Its value.
    #[serde(default)]
    pub estimate: Option<f64>,
    /// 95 % confidence interval; null for an unknown bound.
    #[serde(default)]
    pub ci95: Option<[Option<f64>; 2]>,
    /// Value of a text parameter.
    #[serde(default)]
    pub text: Option<String>,
}

impl ReportedParameter {
    /// The 95 % interval, if both bounds are known.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let [low, high] = self.ci95?;
        Some([low?, high?])
    }
}

/// Channel and times of a finding.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct ReportedLocation {
    /// The channel.
    pub channel: String,
    /// When (s).
    #[serde(default)]
    pub intervals_s: Vec<[f64; 2]>,
}

/// Prediction error over 5 s on held-out data, in standard deviations of the noise.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct ReportedPrediction {
    /// With the nominal model.
    pub nrmse_before: Option<f64>,
    /// With the findings.
    pub nrmse_after: Option<f64>,
}

/// Reads an answer.
///
/// # Errors
/// Why the text is not an answer.
pub fn parse(text: &str) -> Result<DiagnosisAnswer, String> {
    serde_json::from_str(text).map_err(|error| error.to_string())
}
