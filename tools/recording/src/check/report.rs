//! The report of `slipstream check`, as it is written to JSON.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// The result of [`check`](crate::check()).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Version of this format: 1.
    pub format: u32,
    /// Name of the recording.
    pub recording: String,
    /// The streams of each robot.
    pub robots: Vec<RobotReport>,
    /// The findings, sorted by robot (those about no robot first), then by severity.
    pub findings: Vec<Finding>,
    /// What the recording can be used for, as sentences for people.
    pub can_judge: Vec<String>,
    /// What is missing and what it would allow, as sentences for people.
    pub missing: Vec<String>,
}

/// The streams of one robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotReport {
    /// Name of the robot.
    pub robot: String,
    /// Its streams.
    pub streams: Vec<StreamReport>,
}

/// Size and timing of one stream.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StreamReport {
    /// Name of the stream: its CSV file without `.csv`.
    pub stream: String,
    /// Names of its columns without the time.
    pub columns: Vec<String>,
    /// Number of rows.
    pub rows: usize,
    /// First and last time (s); null without rows.
    pub span_s: Option<[f64; 2]>,
    /// Rate (Hz): one over the median time step; null without a positive median.
    pub rate_hz: Option<f64>,
    /// Median deviation of the time steps from their median, over the median (1).
    pub jitter: Option<f64>,
    /// Gaps: time steps longer than five medians and 0.1 s, as [start, end] (s).
    pub gaps_s: Vec<[f64; 2]>,
    /// Number of rows with the same time as the row before.
    pub repeated_times: usize,
    /// Number of empty cells.
    pub empty_cells: usize,
}

/// Severity of a finding, most severe first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A diagnosis of this recording would be wrong.
    Error,
    /// A diagnosis may be wrong, or part of the data is useless.
    Warning,
    /// Worth knowing.
    Note,
}

/// A fault of the recording, or something worth knowing about it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// How severe it is.
    pub severity: Severity,
    /// The robot; null if the finding is about no single robot.
    pub robot: Option<String>,
    /// Identifier for programs, such as `wheels_swapped`; README.md lists all.
    pub id: Cow<'static, str>,
    /// What was found, with the numbers behind it.
    pub statement: String,
    /// How to correct it.
    pub remedy: String,
}

impl Finding {
    pub(super) fn new(
        severity: Severity,
        robot: &str,
        id: &'static str,
        statement: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            severity,
            robot: Some(robot.to_owned()),
            id: Cow::Borrowed(id),
            statement: statement.into(),
            remedy: remedy.into(),
        }
    }
}
