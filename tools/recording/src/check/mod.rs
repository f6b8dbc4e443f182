//! `slipstream check`: finds errors of a recording and says what it can be used for.
//!
//! Needs no model. Sources of the same motion (pose, wheels, command, gyro, odometry) are compared
//! over time windows ([`motion`]); a known factor or a reversed sign between two sources is reported.

mod clocks;
mod coverage;
mod display;
mod links;
mod motion;
mod rates;
mod report;
mod resample;
mod similarity;
mod torque;
mod two_sources;
mod units;
mod wheels;

use slipstream_bus::RobotModel;

pub use report::{Finding, Report, RobotReport, Severity, StreamReport};

use crate::error::Result;
use crate::import::Spooled;
use crate::recording::Recording;
use crate::rows::{AllRows, RobotRows};

/// Checks a recording. `model` gives the size of the wheels and the encoder counts; without it, the
/// model that came with the recording is used, if there is one.
pub fn check(recording: &Recording, model: Option<&RobotModel>) -> Report {
    check_rows(&AllRows::of(recording), model)
}

impl Spooled {
    /// As [`check()`](check()), with the same report, in memory that does not grow with the recording
    /// (but with the number of gaps, which the report lists).
    ///
    /// # Errors
    /// If the temporary file cannot be read.
    pub fn check(&self, model: Option<&RobotModel>) -> Result<Report> {
        let report = check_rows(&self.recording.rows(), model);
        self.recording.disk.check()?;
        Ok(report)
    }
}

fn check_rows(rows: &AllRows<'_>, model: Option<&RobotModel>) -> Report {
    let model = model.or(rows.recording.model.as_ref());
    let mut findings = Vec::new();
    let mut robots = Vec::new();
    for robot in &rows.robots {
        robots.push(rates::report(robot, &mut findings));
        compare_sources(robot, model, &mut findings);
    }
    links::check(rows, &mut findings);
    sort(&mut findings);
    let (can_judge, missing) = coverage::coverage(rows, model);
    Report {
        format: 1,
        recording: rows.recording.name.clone(),
        robots,
        findings,
        can_judge,
        missing,
    }
}

/// The findings of [`check`] that a diagnosis must know: errors, warnings, and gaps in streams.
/// `model_of` gives the model of each robot; without one, the model that came with the recording is
/// used.
pub fn faults(
    recording: &Recording,
    model_of: &dyn Fn(&str) -> Option<RobotModel>,
) -> Vec<Finding> {
    let rows = AllRows::of(recording);
    let mut findings = Vec::new();
    for robot in &rows.robots {
        let model = model_of(&robot.robot.name).or_else(|| recording.model.clone());
        rates::report(robot, &mut findings);
        compare_sources(robot, model.as_ref(), &mut findings);
    }
    links::check(&rows, &mut findings);
    findings.retain(|finding| finding.severity < Severity::Note || finding.id == "gaps");
    sort(&mut findings);
    findings
}

/// Compares the sources of a robot's motion with each other.
fn compare_sources(robot: &RobotRows<'_>, model: Option<&RobotModel>, findings: &mut Vec<Finding>) {
    let lengths_s = [motion::window_s(robot), clocks::STEP_S, torque::WINDOW_S];
    let [windows, steps, short] = motion::windows(robot, model, lengths_s);
    two_sources::check(robot, findings);
    clocks::check(robot, &steps, findings);
    units::check(robot, &windows, findings);
    wheels::check(robot, &windows, findings);
    torque::check(robot, model, &short, findings);
}

/// Sorts by robot, then by severity.
fn sort(findings: &mut [Finding]) {
    findings.sort_by(|a, b| (&a.robot, a.severity).cmp(&(&b.robot, b.severity)));
}
