//! The answer of `slipstream check`.

use serde::Serialize;

/// What was found out about a recording.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Version of this answer's form.
    pub format: u32,
    /// The recording's name.
    pub recording: String,
    /// Each robot's streams.
    pub robots: Vec<RobotReport>,
    /// What is wrong or worth knowing, the worst first within each robot.
    pub findings: Vec<Finding>,
    /// What can be judged from it.
    pub can_judge: Vec<String>,
    /// What is missing, and what it would allow.
    pub missing: Vec<String>,
}

/// One robot's streams.
#[derive(Debug, Clone, Serialize)]
pub struct RobotReport {
    /// The robot.
    pub robot: String,
    /// Its streams.
    pub streams: Vec<StreamReport>,
}

/// Times of one stream.
#[derive(Debug, Clone, Serialize)]
pub struct StreamReport {
    /// Its file's name without `.csv`.
    pub stream: String,
    /// Its columns.
    pub columns: Vec<String>,
    /// Number of rows.
    pub rows: usize,
    /// First and last time (s); null without rows.
    pub span_s: Option<[f64; 2]>,
    /// One over the median of the time from row to row (1/s).
    pub rate_hz: Option<f64>,
    /// Median deviation of the time from row to row from its median, over the median (1).
    pub jitter: Option<f64>,
    /// Pauses longer than five times the median and 0.1 s: from, to (s).
    pub gaps_s: Vec<[f64; 2]>,
    /// Rows with the time of the row before.
    pub repeated_times: usize,
    /// Empty cells.
    pub empty_cells: usize,
}

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A diagnosis of this recording would be wrong.
    Error,
    /// It may be wrong, or part of the data is of no use.
    Warning,
    /// Worth knowing.
    Note,
}

/// Something that is wrong or worth knowing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// The robot; null when it is about all.
    pub robot: Option<String>,
    /// A word for programs, such as `wheels_swapped`.
    pub id: &'static str,
    /// What it is, with the numbers behind it.
    pub statement: String,
    /// What to do about it.
    pub remedy: String,
}

impl Finding {
    pub(crate) fn new(
        severity: Severity,
        robot: &str,
        id: &'static str,
        statement: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            severity,
            robot: Some(robot.to_owned()),
            id,
            statement: statement.into(),
            remedy: remedy.into(),
        }
    }
}
