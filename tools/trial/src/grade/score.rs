//! The score of one case.

use serde::{Deserialize, Serialize};

/// The grade of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrialGrade {
    /// Verdict, effects, robots, channels, intervals and parameters are right.
    Exact,
    /// Effects and robots are right, something else is not.
    Inexact,
    /// Not the effect itself, but one declared to be indistinguishable from it.
    LookAlike,
    /// An unknown effect was reported although the vocabulary contains the effect.
    Flagged,
    /// The effect was not found, and nothing wrong was reported.
    Missed,
    /// An effect was reported that is not there.
    Wrong,
    /// Something was reported although nothing is there.
    FalseAlarm,
    /// No answer: an error or a timeout.
    Failed,
}

impl TrialGrade {
    /// All grades, best first.
    pub const ALL: [Self; 8] = [
        Self::Exact,
        Self::Inexact,
        Self::LookAlike,
        Self::Flagged,
        Self::Missed,
        Self::Wrong,
        Self::FalseAlarm,
        Self::Failed,
    ];

    /// Its name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Inexact => "inexact",
            Self::LookAlike => "look_alike",
            Self::Flagged => "flagged",
            Self::Missed => "missed",
            Self::Wrong => "wrong",
            Self::FalseAlarm => "false_alarm",
            Self::Failed => "failed",
        }
    }
}

/// What is noted of an answer whatever its grade.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AnswerFlag {
    /// The input was called unusable (exit code 2).
    Refused,
    /// A confident verdict beside a prediction error that it does not allow.
    Contradiction,
    /// With the findings a unit is predicted worse than with the nominal model.
    Worse,
}

/// The score of one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseScore {
    /// The grade.
    #[serde(rename = "outcome")]
    pub grade: TrialGrade,
    /// Pairs of a true effect and the reported one; `none` for nothing.
    pub pairs: Vec<[String; 2]>,
    /// Why the answer is not exact.
    pub remarks: Vec<String>,
    /// What is noted of the answer whatever its grade.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flags: Vec<AnswerFlag>,
    /// The parameters of the effects that were identified.
    pub parameters: Vec<ParameterScore>,
    /// Prediction error over 5 s on held-out data, with the nominal model and with the findings, in
    /// standard deviations of the noise.
    pub held_out: Option<[f64; 2]>,
}

/// The score of one estimated parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterScore {
    /// Its effect.
    pub effect: String,
    /// Its name.
    pub name: String,
    /// True value.
    pub truth: f64,
    /// Estimated value.
    pub estimate: f64,
    /// Whether the 95 % interval contains the true value; null without an interval.
    pub covered: Option<bool>,
    /// Error in standard deviations as stated by the answer; null without an interval.
    pub error_in_stated_deviations: Option<f64>,
    /// Error in the smallest possible standard deviations, if the label contains them.
    pub error_in_least_deviations: Option<f64>,
}
