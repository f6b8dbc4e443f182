//! Degrees for radians, millimetres for metres: factors between sources of the same motion.

use std::f64::consts::TAU;

use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::{agreement, combine};
use crate::recording::{Robot, unwrap};

/// Degrees in a radian.
const DEGREES: f64 = 360.0 / TAU;

/// Two sources of the same quantity, and what a factor between them would mean.
struct Pair<'a> {
    first: &'a str,
    a: &'a [f64],
    second: &'a str,
    b: &'a [f64],
    /// Factor from second to first, what it means, what to do.
    factors: &'a [(f64, &'a str)],
}

const SPEEDS: [(f64, &str); 6] = [
    (1000.0, "the first is in mm, or the second in km"),
    (100.0, "the first is in cm"),
    (
        DEGREES,
        "the second's angles are off by the factor from degrees to radians",
    ),
    (1.0 / DEGREES, "the second's angles are in degrees"),
    (0.01, "the second is in cm"),
    (0.001, "the second is in mm"),
];

const TURNS: [(f64, &str); 2] = [
    (DEGREES, "the first is in degrees"),
    (1.0 / DEGREES, "the second is in degrees"),
];

/// Findings about units.
pub(super) fn of(robot: &Robot, windows: &Windows, findings: &mut Vec<Finding>) {
    let mut yaw_in_degrees = yaw_in_degrees(robot, windows);
    let (wheels_v, wheels_w) = twist_of_wheels(windows);
    let pair = |first, a, second, b, factors| Pair {
        first,
        a,
        second,
        b,
        factors,
    };
    let mut pairs: Vec<Pair<'_>> = Vec::new();
    if !yaw_in_degrees {
        pairs.push(pair(
            "pose",
            &windows.pose_v,
            "command",
            &windows.command_v,
            &SPEEDS,
        ));
        pairs.push(pair("pose", &windows.pose_v, "wheels", &wheels_v, &SPEEDS));
        pairs.push(pair(
            "pose",
            &windows.pose_v,
            "odometry",
            &windows.odometry_v,
            &SPEEDS,
        ));
        pairs.push(pair(
            "pose",
            &windows.pose_w,
            "gyro",
            &windows.gyro_w,
            &TURNS,
        ));
        pairs.push(pair("pose", &windows.pose_w, "wheels", &wheels_w, &TURNS));
        pairs.push(pair(
            "pose",
            &windows.pose_w,
            "command",
            &windows.command_w,
            &TURNS,
        ));
    }
    pairs.push(pair(
        "wheels",
        &wheels_v,
        "command",
        &windows.command_v,
        &SPEEDS,
    ));
    pairs.push(pair("gyro", &windows.gyro_w, "wheels", &wheels_w, &TURNS));
    pairs.push(pair(
        "gyro",
        &windows.gyro_w,
        "command",
        &windows.command_w,
        &TURNS,
    ));
    for pair in pairs {
        if let Some(finding) = factor(&robot.name, &pair) {
            yaw_in_degrees &= finding.id != "units";
            findings.push(finding);
        }
    }
    if yaw_in_degrees {
        let statement = "the pose's yaw is in degrees: only then does it point along the motion";
        let remedy = "convert yaw_rad to radians";
        findings.push(Finding::new(
            Severity::Error,
            &robot.name,
            "units",
            statement,
            remedy,
        ));
    }
}

/// Whether the heading lies along the motion when read as degrees, and does not as radians; or
/// jumps by 360 and never by a turn.
fn yaw_in_degrees(robot: &Robot, windows: &Windows) -> bool {
    let mean = |cosines: &[f64]| {
        let seen: Vec<f64> = cosines.iter().copied().filter(|c| c.is_finite()).collect();
        (seen.len() >= 10).then(|| (seen.iter().sum::<f64>() / seen.len() as f64).abs())
    };
    let yaw = robot
        .pose
        .as_ref()
        .and_then(|pose| pose.values.yaw_rad.as_ref());
    let Some(yaw) = yaw else {
        return false;
    };
    // Radians of a few turns are possible, but then they grow without jumps.
    let steps = yaw
        .iter()
        .zip(yaw.iter().skip(1))
        .map(|(a, b)| (b - a).abs());
    let jumps = steps.filter(|step| (350.0..370.0).contains(step)).count();
    let largest = unwrap(yaw)
        .iter()
        .chain(yaw)
        .fold(0.0_f64, |a, b| a.max(b.abs()));
    let [radians, degrees] = &windows.heading_cos;
    let along = matches!((mean(radians), mean(degrees)), (Some(r), Some(d)) if d > 0.8 && r < 0.5);
    largest > TAU && (along || jumps > 0)
}

/// Forward speed and yaw rate by the wheels, where their size is known.
pub(super) fn twist_of_wheels(windows: &Windows) -> (Vec<f64>, Vec<f64>) {
    let Some([r, b]) = windows.size_m.filter(|_| windows.wheels_in_rad) else {
        return (Vec::new(), Vec::new());
    };
    let (right, left) = (&windows.wheel_right, &windows.wheel_left);
    (
        combine(right, left, |right, left| r * (right + left) / 2.0),
        combine(right, left, |right, left| r * (right - left) / (2.0 * b)),
    )
}

/// A finding where the two are the same up to one of the known factors, within 30 %.
fn factor(robot: &str, pair: &Pair<'_>) -> Option<Finding> {
    let agreement = agreement(pair.a, pair.b)?;
    if agreement.cosine.abs() < 0.7 {
        return None;
    }
    let size = agreement.factor.abs();
    let near = |known: f64| (size / known).ln().abs() < 0.26;
    let (_, meaning) = pair.factors.iter().find(|(known, _)| near(*known))?;
    let (first, second) = (pair.first, pair.second);
    let meaning = meaning
        .replace("the first", first)
        .replace("the second", second);
    let statement = format!("{first} over {second} is {size:.3} and should be near 1: {meaning}");
    let remedy = "convert it to SI units and radians";
    Some(Finding::new(
        Severity::Error,
        robot,
        "units",
        statement,
        remedy,
    ))
}
