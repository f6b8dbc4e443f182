//! `slipstream check`: what a recording can be used for, before any diagnosis.
//!
//! Nothing here needs a model. Sources of the same motion (pose, wheels, command, gyro, odometry)
//! are compared in windows ([`motion`]); what they disagree on by a known factor or sign is said.

mod clocks;
mod coverage;
mod motion;
mod rates;
mod text;
mod torque;
mod units;
mod wheels;

pub(crate) use motion::unwrap;

use serde::Serialize;
use slipstream_bus::RobotModel;

use crate::recording::{Recording, Robot};

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

/// Looks a recording over. Without a model, the one that came with the recording is used for the
/// wheels' size and the encoders' counts.
pub fn check(recording: &Recording, model: Option<&RobotModel>) -> Report {
    let model = model.or(recording.model.as_ref());
    let mut findings = Vec::new();
    let mut robots = Vec::new();
    for robot in &recording.robots {
        robots.push(rates::of(robot, &mut findings));
        of_robot(robot, model, &mut findings);
    }
    clocks::of_links(recording, &mut findings);
    findings.sort_by(|a, b| (&a.robot, a.severity).cmp(&(&b.robot, b.severity)));
    let (can_judge, missing) = coverage::of(recording, model);
    Report {
        format: 1,
        recording: recording.name.clone(),
        robots,
        findings,
        can_judge,
        missing,
    }
}

fn of_robot(robot: &Robot, model: Option<&RobotModel>, findings: &mut Vec<Finding>) {
    let windows = motion::windows(robot, model);
    clocks::of_robot(robot, model, findings);
    units::of(robot, &windows, findings);
    wheels::of(robot, &windows, findings);
    torque::of(robot, model, findings);
}

/// What is wrong with a recording that a diagnosis of it has to know: faults, and pauses of its
/// streams. Each robot is looked at by its own model, or by the one that came with the recording.
pub fn faults(
    recording: &Recording,
    model_of: &dyn Fn(&str) -> Option<RobotModel>,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    for robot in &recording.robots {
        let model = model_of(&robot.name).or_else(|| recording.model.clone());
        rates::of(robot, &mut findings);
        of_robot(robot, model.as_ref(), &mut findings);
    }
    clocks::of_links(recording, &mut findings);
    findings.retain(|finding| finding.severity < Severity::Note || finding.id == "gaps");
    findings.sort_by(|a, b| (&a.robot, a.severity).cmp(&(&b.robot, b.severity)));
    findings
}
