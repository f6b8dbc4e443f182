//! Labels: the truth about a case, concealed from the diagnosis.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::TrialError;

/// Labels by the name of the recording's folder, ordered by name.
pub type Labels = BTreeMap<String, Label>;

/// The truth about one recording. Keys not listed here are notes and ignored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// Verdict of a correct diagnosis.
    pub verdict: DiagnosisVerdict,
    /// File of the nominal model, relative to the folder of the labels.
    pub robot_toml: String,
    /// Kind of case: `single`, `pair`, `null`, `outside`, …; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub kind: String,
    /// How the case was made, for human readers.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub notes: BTreeMap<String, String>,
    /// Effects removed from the catalogue of the diagnosis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
    /// What else is in the recording and is no effect: faults of loggers, noise, drives outside the vocabulary.
    /// With any, a case without effects that is answered `unexplained` without a name is inexact.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nuisances: Vec<String>,
    /// Findings that these bring and that are neither asked for nor wrong. With `unknown` among them, the verdict
    /// `unexplained` is right as well.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub allowed: Vec<String>,
    /// Effects of the vocabulary that are in the recording but not in the model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<ConcealedEffect>,
    /// Physics outside the vocabulary.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unknown: Option<UnknownPhysics>,
}

impl Label {
    /// Whether nothing is concealed.
    pub fn is_null(&self) -> bool {
        self.effects.is_empty() && self.unknown.is_none()
    }
}

/// The verdict of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DiagnosisVerdict {
    /// Nothing beyond the noise was found.
    Match,
    /// The findings explain the recording.
    Explained,
    /// Something significant remains unexplained.
    Unexplained,
}

/// An effect of the vocabulary that is concealed in a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConcealedEffect {
    /// Id of the effect.
    pub effect: String,
    /// The robot.
    pub robot: String,
    /// Its true parameters.
    pub parameters: BTreeMap<String, ParameterValue>,
    /// Channels, each of which is a correct answer.
    pub channels: Vec<String>,
    /// Effects that cannot be distinguished from it in this recording.
    #[serde(default)]
    pub confusions: Vec<String>,
    /// When it acted (s); empty if always.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub intervals_s: Vec<[f64; 2]>,
    /// Expected log-likelihood gain (nats) of the true model over the model without this effect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_gain: Option<f64>,
    /// Smallest possible standard deviation of each parameter (Cramér-Rao bound).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub deviations: BTreeMap<String, f64>,
    /// Runs of one machine in which it acts with these parameters; empty: all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<String>,
    /// Absolute error up to which a parameter is right whatever its interval.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tolerances: BTreeMap<String, f64>,
}

/// Physics outside the vocabulary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnknownPhysics {
    /// The robot.
    pub robot: String,
    /// Name of its kind.
    pub kind: String,
    /// Its true parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, ParameterValue>,
    /// Channels, each of which is a correct answer.
    pub channels: Vec<String>,
    /// Drivers, each of which is a correct answer.
    pub driver: Vec<String>,
    /// When it acted (s); empty if always.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub intervals_s: Vec<[f64; 2]>,
    /// Expected log-likelihood gain (nats) of the true model over the model without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_gain: Option<f64>,
}

/// A parameter's value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ParameterValue {
    /// In the unit that ends the parameter's name.
    Number(f64),
    /// For example the name of a stream.
    Text(String),
    /// For example the knots of a table.
    List(Vec<f64>),
}

/// Reads a file of labels.
///
/// # Errors
/// A file that cannot be read or does not contain labels; names the line and the remedy.
pub fn read(path: &Path) -> Result<Labels, TrialError> {
    let text = std::fs::read_to_string(path).map_err(|error| {
        let remedy = "give a file of labels such as `slipstream trial --out FOLDER` writes";
        TrialError::input(path.display(), error.to_string(), remedy)
    })?;
    parse(&text, path)
}

/// Parses the text of a file of labels; `path` is used in errors only.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<Labels, TrialError> {
    let labels: Labels = toml::from_str(text).map_err(|error| {
        let before = text
            .as_bytes()
            .iter()
            .take(error.span().map_or(0, |span| span.start));
        let line = 1 + before.filter(|&&byte| byte == b'\n').count();
        let place = format!("{}:{line}", path.display());
        TrialError::input(
            place,
            error.message(),
            "see the section on labels in tools/trial/README.md",
        )
    })?;
    match labels
        .keys()
        .find(|name| !slipstream_recording::recording::is_robot_name(name))
    {
        None => Ok(labels),
        Some(name) => Err(TrialError::input(
            path.display(),
            format!("{name:?} names no folder beside it"),
            "name each case after its folder",
        )),
    }
}

/// The text of a file of labels; reading it gives the same labels.
///
/// # Errors
/// None in practice: labels hold only numbers, texts and lists.
pub fn to_text(labels: &Labels) -> Result<String, toml::ser::Error> {
    toml::to_string(labels)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
[a-01]
verdict = "explained"
robot_toml = "robots/a-01.toml"
control = "a note"
[[a-01.effects]]
effect = "clock_drift"
robot = "r1"
parameters = { rate = 1, stream = "pose" }
channels = ["sensor_pose"]
intervals_s = [[1.0, 2.5]]
"#;

    #[test]
    fn labels_are_read_and_written() {
        let labels = parse(TEXT, Path::new("labels.toml")).unwrap();
        let concealed = &labels["a-01"].effects[0];
        assert_eq!(concealed.parameters["rate"], ParameterValue::Number(1.0));
        assert_eq!(
            concealed.parameters["stream"],
            ParameterValue::Text("pose".to_owned())
        );
        let again = parse(&to_text(&labels).unwrap(), Path::new("again.toml")).unwrap();
        assert_eq!(again, labels);
    }

    #[test]
    fn an_error_names_its_line() {
        let error = parse(&TEXT.replace("robot = \"r1\"\n", ""), Path::new("l.toml")).unwrap_err();
        let words = error.to_string();
        assert!(
            words.starts_with("l.toml:6: missing field `robot`"),
            "{words}"
        );
        let up = "[\"../up\"]\nverdict = \"match\"\nrobot_toml = \"r.toml\"\n";
        let error = parse(up, Path::new("l.toml")).unwrap_err().to_string();
        assert!(error.contains("names no folder"), "{error}");
    }
}
