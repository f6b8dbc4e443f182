//! What a diagnosis answered (its JSON), as far as a trial judges it.

use serde::Deserialize;

use crate::label::Verdict;

/// The answer.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Answer {
    /// What it comes to.
    pub verdict: Verdict,
    /// What the model leaves out.
    #[serde(default)]
    pub findings: Vec<Finding>,
    /// Prediction over 5 s, before and after.
    #[serde(default)]
    pub held_out: Option<HeldOut>,
}

/// One effect that was named, or `unknown`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Finding {
    /// Whose.
    pub robot: String,
    /// Its identity.
    pub effect: String,
    /// How much.
    #[serde(default)]
    pub parameters: Vec<Parameter>,
    /// Where and when.
    #[serde(rename = "where")]
    pub place: Place,
    /// What it was said to be inseparable from.
    #[serde(default)]
    pub confused_with: Vec<String>,
    /// On what an `unknown` depends.
    #[serde(default)]
    pub driver: Option<String>,
}

/// A parameter with its interval, or a word.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value.
    #[serde(default)]
    pub estimate: Option<f64>,
    /// Where it lies with 95 % confidence; a bound that is null is not known.
    #[serde(default)]
    pub ci95: Option<[Option<f64>; 2]>,
    /// Its value, where that is a word.
    #[serde(default)]
    pub text: Option<String>,
}

impl Parameter {
    /// The 95 % interval, where both of its bounds are known.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let [low, high] = self.ci95?;
        Some([low?, high?])
    }
}

/// Where and when a finding shows.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct Place {
    /// The channel.
    pub channel: String,
    /// When (s).
    #[serde(default)]
    pub intervals_s: Vec<[f64; 2]>,
}

/// Prediction over 5 s on data that was held back, in noise deviations.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct HeldOut {
    /// With the nominal model.
    pub nrmse_before: Option<f64>,
    /// With the findings.
    pub nrmse_after: Option<f64>,
}

/// Reads an answer.
///
/// # Errors
/// What is no answer, in words.
pub fn parse(text: &str) -> Result<Answer, String> {
    serde_json::from_str(text).map_err(|error| error.to_string())
}
