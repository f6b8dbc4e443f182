//! `slipstream check`: finds errors of a recording and says what it can be used for.
//!
//! Needs no model. Sources of the same motion (pose, wheels, command, gyro, odometry) are compared
//! over time windows ([`motion`]); a known factor or a reversed sign between two sources is reported.

mod assignment;
mod clocks;
mod counters;
mod coverage;
mod cure;
mod display;
mod levels;
mod links;
mod machines;
mod motion;
mod rates;
mod report;
mod resample;
mod similarity;
mod still;
mod torque;
mod two_sources;
mod units;
mod wheel_scale;
mod wheels;

use slipstream_bag::Result;
use slipstream_bus::RobotModel;

pub(crate) use counters::{BURSTING, of_bursts};
pub use report::{Finding, Report, RobotReport, Severity, StreamReport};

use self::machines::{Machines, OfRun};
use self::motion::Windows;
use crate::import::Spooled;
use crate::mend::{self, PoseJump, WheelFaults};
use crate::recording::Recording;
use crate::rows::{AllRows, RobotRows};
use crate::table::StreamKind;

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

/// A recording that is shorter has one window of a prediction (5 s) and no second one to test it (s).
const SHORT_S: f64 = 10.0;

fn check_rows(rows: &AllRows<'_>, model: Option<&RobotModel>) -> Report {
    let model = model.or(rows.recording.model.as_ref());
    let mut findings = Vec::new();
    let mut robots = Vec::new();
    let mut machines = Machines::default();
    for robot in &rows.robots {
        robots.push(rates::report(robot, &mut findings));
        let run = compare_sources(robot, model, &mut findings);
        machines.add((0, rows.recording), &robot.robot.name, run);
    }
    findings.extend(machines.findings().into_iter().map(|(_, finding)| finding));
    links::check(rows, &mut findings);
    findings.extend(short(rows));
    cure::add(rows.recording.read_from, &mut findings);
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

/// The findings of [`check`] that a diagnosis must know, for each recording: errors, warnings, and gaps in streams.
/// Recordings of one machine are judged together. `model_of` gives the model of each robot; without one, the model
/// that came with the recording is used.
pub fn faults(
    recordings: &[Recording],
    model_of: &dyn Fn(&str) -> Option<RobotModel>,
) -> Vec<Vec<Finding>> {
    let mut machines = Machines::default();
    let mut all = Vec::new();
    for (number, recording) in recordings.iter().enumerate() {
        let rows = AllRows::of(recording);
        let mut findings = Vec::new();
        for robot in &rows.robots {
            let model = model_of(&robot.robot.name).or_else(|| recording.model.clone());
            rates::report(robot, &mut findings);
            let run = compare_sources(robot, model.as_ref(), &mut findings);
            machines.add((number, recording), &robot.robot.name, run);
        }
        links::check(&rows, &mut findings);
        findings.extend(short(&rows));
        all.push(findings);
    }
    for (number, finding) in machines.findings() {
        all[number].push(finding);
    }
    for (findings, recording) in all.iter_mut().zip(recordings) {
        cure::add(recording.read_from, findings);
        findings.retain(is_worth_knowing);
        sort(findings);
    }
    all
}

/// The jumps of all robots' poses that stay: the poses before and after are in different frames.
pub fn pose_jumps(recording: &Recording) -> Vec<PoseJump> {
    let rows = AllRows::of(recording);
    let each = rows.robots.iter();
    let model = recording.model.as_ref();
    let all = each.flat_map(|robot| counters::pose_jumps(robot, counters(robot, model).as_ref()));
    all.collect()
}

/// What is wrong with a robot's wheels and poses, and what is said of columns, jumps, and a heading that was not
/// measured.
pub(crate) struct Faults {
    pub(crate) wheels: Option<WheelFaults>,
    pub(crate) poses: PoseFaults,
    pub(crate) of_wheels: Vec<Finding>,
    pub(crate) of_jumps: Option<Finding>,
    pub(crate) of_heading: Option<Finding>,
}

/// What is wrong with a robot's poses.
#[derive(Debug, Default)]
pub(crate) struct PoseFaults {
    pub(crate) jumps: Vec<PoseJump>,
    /// Times in which the pose stays at one value while the wheels turn (s), known to `window_s`.
    pub(crate) lost_s: Vec<[f64; 2]>,
    pub(crate) window_s: f64,
}

impl PoseFaults {
    pub(crate) fn is_clean(&self) -> bool {
        self.jumps.is_empty() && self.lost_s.is_empty()
    }
}

/// What is wrong with a robot's wheels and poses.
pub(crate) fn faults_of(robot: &RobotRows<'_>, model: Option<&RobotModel>) -> Faults {
    let mut wheels = counters(robot, model);
    let window_s = motion::window_s(robot);
    let [mut windows] = motion::windows(robot, model, [window_s], wheels.as_ref());
    let of_wheels = wheels.as_mut().map_or_else(Vec::new, |faults| {
        of_columns(robot, faults, &mut [&mut windows])
    });
    let jumps = counters::pose_jumps(robot, wheels.as_ref());
    Faults {
        of_jumps: counters::of_pose_jumps(robot, &jumps),
        of_heading: still::heading(&robot.robot.name, &windows, window_s),
        poses: PoseFaults {
            jumps,
            lost_s: still::lost(&windows, window_s),
            window_s,
        },
        wheels,
        of_wheels,
    }
}

fn counters(robot: &RobotRows<'_>, model: Option<&RobotModel>) -> Option<WheelFaults> {
    let rows = robot.stream(StreamKind::Wheels)?;
    mend::wheels(rows, robot.robot.counts_per_rev(model))
}

/// The findings about the wheels' columns. What they hold is entered into the faults and the windows.
fn of_columns(
    robot: &RobotRows<'_>,
    faults: &mut WheelFaults,
    windows: &mut [&mut Windows],
) -> Vec<Finding> {
    let name = &robot.robot.name;
    let interval_s = robot.stream(StreamKind::Wheels).and_then(mend::interval_s);
    let seen = interval_s.and_then(|interval_s| {
        let seen = levels::seen(windows.first()?, faults, interval_s)?;
        Some((seen, interval_s))
    });
    let Some((seen, interval_s)) = seen else {
        return counters::of_wheels(name, faults);
    };
    // values that are no counter have no faults of one
    faults.faults = Default::default();
    faults.level = seen.level;
    if let Some(level) = seen.level {
        let each = windows.iter_mut();
        each.for_each(|windows| windows.read_levels(level, interval_s));
    }
    vec![seen.finding(name, faults)]
}

/// Whether a diagnosis must know of it.
fn is_worth_knowing(finding: &Finding) -> bool {
    finding.severity < Severity::Note || ["gaps", "short", "sides_unclear"].contains(&&*finding.id)
}

/// A note about a recording that is too short to hold time out.
fn short(rows: &AllRows<'_>) -> Option<Finding> {
    let spans = rows.robots.iter().filter_map(motion::span);
    let total_s = spans.map(|[start, end]| end - start).reduce(|a, b| a + b)?;
    (total_s < SHORT_S).then(|| Finding {
        severity: Severity::Note,
        robot: None,
        id: "short".into(),
        statement: format!(
            "{total_s:.1} s of data: what is found holds for this one piece of a course, and there is none to test it on"
        ),
        remedy: format!("record for {:.0} s or longer, with straights and turns", 3.0 * SHORT_S),
    })
}

/// Compares the sources of a robot's motion with each other. Returns what its machine is judged by.
fn compare_sources(
    robot: &RobotRows<'_>,
    model: Option<&RobotModel>,
    findings: &mut Vec<Finding>,
) -> OfRun {
    let window_s = motion::window_s(robot);
    let lengths_s = [window_s, clocks::STEP_S, torque::WINDOW_S];
    let mut faults = counters(robot, model);
    let [mut windows, mut steps, mut short] =
        motion::windows(robot, model, lengths_s, faults.as_ref());
    if let Some(faults) = &mut faults {
        let all = &mut [&mut windows, &mut steps, &mut short];
        findings.extend(of_columns(robot, faults, all));
    }
    findings.extend(of_bursts(robot));
    let jumps = counters::pose_jumps(robot, faults.as_ref());
    findings.extend(counters::of_pose_jumps(robot, &jumps));
    two_sources::check(robot, findings);
    still::check(robot, &windows, window_s, findings);
    findings.extend(still::heading(&robot.robot.name, &windows, window_s));
    clocks::check(robot, &steps, findings);
    units::check(robot, &windows, findings);
    let mut of_torques = Vec::new();
    torque::check(robot, model, &short, &mut of_torques);
    OfRun {
        windows,
        of_torques,
    }
}

/// Sorts by robot, then by severity.
fn sort(findings: &mut [Finding]) {
    findings.sort_by(|a, b| (&a.robot, a.severity).cmp(&(&b.robot, b.severity)));
}
