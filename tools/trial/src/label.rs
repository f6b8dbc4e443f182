//! The truth about a case: what was concealed in its recording.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::TrialError;

/// Labels by the name of the recording's folder, in the order of the names.
pub type Labels = BTreeMap<String, Label>;

/// What one recording holds. Keys that are not listed here are notes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// What a right diagnosis says.
    pub verdict: Verdict,
    /// The nominal model, relative to the labels' folder.
    pub robot_toml: String,
    /// What drew the case: `single`, `pair`, `null`, `outside`, …; empty where nobody said.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub kind: String,
    /// How the case was made, for people.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub notes: BTreeMap<String, String>,
    /// Effects that the diagnosis gets its catalogue without.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
    /// Effects of the vocabulary that the recording has and the model leaves out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<Hidden>,
    /// Physics outside the vocabulary.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unknown: Option<Unknown>,
}

/// The verdict of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing beyond the noise.
    Match,
    /// What was found explains the recording.
    Explained,
    /// Something significant remains.
    Unexplained,
}

/// One effect of the vocabulary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hidden {
    /// Its identity.
    pub effect: String,
    /// Whose.
    pub robot: String,
    /// Its true parameters.
    pub parameters: BTreeMap<String, Value>,
    /// Channels any of which is right.
    pub channels: Vec<String>,
    /// Effects that this recording cannot tell from it.
    #[serde(default)]
    pub confusions: Vec<String>,
    /// When it was at work (s); empty: always.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub intervals_s: Vec<[f64; 2]>,
    /// Nats by which the true model beats the model without this effect, in expectation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_gain: Option<f64>,
    /// Smallest deviation that any estimator can have, by parameter (Cramér and Rao).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub deviations: BTreeMap<String, f64>,
}

/// Physics outside the vocabulary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unknown {
    /// Whose.
    pub robot: String,
    /// What it is.
    pub kind: String,
    /// Its true parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, Value>,
    /// Channels any of which is right.
    pub channels: Vec<String>,
    /// Variables any of which is right.
    pub driver: Vec<String>,
    /// When it was at work (s); empty: always.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub intervals_s: Vec<[f64; 2]>,
    /// Nats by which the true model beats the model without it, in expectation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_gain: Option<f64>,
}

/// A parameter's value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// In the unit that the parameter's name carries.
    Number(f64),
    /// Such as the name of a stream.
    Text(String),
}

/// Reads a file of labels.
///
/// # Errors
/// A file that cannot be read, or is no file of labels: with line and remedy.
pub fn read(path: &Path) -> Result<Labels, TrialError> {
    let text = std::fs::read_to_string(path).map_err(|error| {
        let remedy = "give a file of labels such as `slipstream trial --out FOLDER` writes";
        TrialError::unusable(path.display(), error.to_string(), remedy)
    })?;
    parse(&text, path)
}

/// Parses the text of a file of labels; `path` is only for errors.
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
        TrialError::unusable(
            place,
            error.message(),
            "give each case as the README of trial says",
        )
    })?;
    match labels
        .keys()
        .find(|name| !slipstream_recording::recording::is_robot_name(name))
    {
        None => Ok(labels),
        Some(name) => Err(TrialError::unusable(
            path.display(),
            format!("{name:?} names no folder beside it"),
            "name each case after its folder",
        )),
    }
}

/// The text of a file of labels: reading it again gives the same labels.
///
/// # Errors
/// None that a label can cause: numbers, texts and lists are all that it holds.
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
        let hidden = &labels["a-01"].effects[0];
        assert_eq!(hidden.parameters["rate"], Value::Number(1.0));
        assert_eq!(hidden.parameters["stream"], Value::Text("pose".to_owned()));
        let again = parse(&to_text(&labels).unwrap(), Path::new("again.toml")).unwrap();
        assert_eq!(again, labels);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
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
