//! `slipstream check`: what a recording can be used for, before any diagnosis.
//!
//! Nothing here needs a model. Sources of the same motion (pose, wheels, command, gyro, odometry)
//! are compared in windows ([`motion`]); what they disagree on by a known factor or sign is said.

mod clocks;
mod coverage;
mod display;
mod motion;
mod rates;
mod report;
mod resample;
mod similarity;
mod torque;
mod units;
mod wheels;

use slipstream_bus::RobotModel;

pub use report::{Finding, Report, RobotReport, Severity, StreamReport};

use crate::recording::{Recording, Robot};

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
