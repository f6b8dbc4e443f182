//! Units: degrees instead of radians, millimetres or centimetres instead of metres.
//!
//! A wrong unit shows as a known factor between two sources of the same motion.

use std::f64::consts::TAU;

use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::similarity;
use super::wheel_scale;
use crate::rows::RobotRows;

/// Degrees per radian.
const DEGREES: f64 = 360.0 / TAU;
/// Smallest cosine similarity at which the factor between two sources is judged.
const MIN_SIMILARITY: f64 = 0.7;
/// Largest deviation of the factor from a known one, as a natural logarithm (30 %).
const MAX_LN_DEVIATION: f64 = 0.26;
/// Fewest windows with motion that are needed to judge the yaw by the direction of motion.
const MIN_MOVING_WINDOWS: usize = 10;

/// Two sources of the same quantity.
struct SourcePair<'a> {
    first: &'a str,
    a: &'a [f64],
    second: &'a str,
    b: &'a [f64],
    /// Known factors from the second source to the first, with their meaning.
    factors: &'a [(f64, &'a str)],
}

/// Known factors between forward speeds.
const SPEEDS: [(f64, &str); 4] = [
    (1000.0, "the first is in mm, or the second in km"),
    (100.0, "the first is in cm"),
    (0.01, "the second is in cm"),
    (0.001, "the second is in mm"),
];

/// Known factors between yaw rates.
const TURNS: [(f64, &str); 2] = [
    (DEGREES, "the first is in degrees"),
    (1.0 / DEGREES, "the second is in degrees"),
];

/// Adds findings about units.
pub(super) fn check(robot: &RobotRows<'_>, windows: &Windows, findings: &mut Vec<Finding>) {
    let mut yaw_in_degrees = yaw_is_in_degrees(windows);
    let (wheels_v, wheels_w) = windows.wheel_twist();
    // With a yaw in degrees, neither speed nor yaw rate of the pose means anything.
    let with_pose = !yaw_in_degrees;
    let miscounted = wheel_scale::known(windows, &wheels_v, with_pose);
    // what miscounts says nothing about the units of others
    let apart = |pair: &SourcePair<'_>| {
        miscounted.is_some() && [pair.first, pair.second].contains(&"wheels")
    };
    for pair in pairs(windows, &wheels_v, &wheels_w, with_pose).filter(|pair| !apart(pair)) {
        if let Some(finding) = known_factor(&robot.robot.name, &pair) {
            yaw_in_degrees &= finding.id != "units";
            findings.push(finding);
        }
    }
    if yaw_in_degrees {
        let statement = "the pose's yaw is in degrees: only then does it point along the motion";
        let remedy = "convert yaw_rad to radians";
        findings.push(Finding::new(
            Severity::Error,
            &robot.robot.name,
            "units",
            statement,
            remedy,
        ));
    }
}

/// The pairs to compare, with or without the pose.
fn pairs<'a>(
    windows: &'a Windows,
    wheels_v: &'a [f64],
    wheels_w: &'a [f64],
    with_pose: bool,
) -> impl Iterator<Item = SourcePair<'a>> {
    let Windows {
        pose_v,
        pose_w,
        gyro_w,
        odometry_v,
        command_v,
        command_w,
        ..
    } = windows;
    let speeds = |first, a, second, b| SourcePair {
        first,
        a,
        second,
        b,
        factors: &SPEEDS,
    };
    let turns = |first, a, second, b| SourcePair {
        first,
        a,
        second,
        b,
        factors: &TURNS,
    };
    let of_pose = [
        speeds("pose", pose_v, "command", command_v),
        speeds("pose", pose_v, "wheels", wheels_v),
        speeds("pose", pose_v, "odometry", odometry_v),
        turns("pose", pose_w, "gyro", gyro_w),
        turns("pose", pose_w, "wheels", wheels_w),
        turns("pose", pose_w, "command", command_w),
    ];
    let others = [
        speeds("wheels", wheels_v, "command", command_v),
        turns("gyro", gyro_w, "wheels", wheels_w),
        turns("gyro", gyro_w, "command", command_w),
    ];
    let of_pose = of_pose.into_iter().filter(move |_| with_pose);
    of_pose.chain(others)
}

/// Whether the yaw is in degrees: it points along the motion when read as degrees and not when read as
/// radians, or it jumps by 360 and is larger than a turn.
fn yaw_is_in_degrees(windows: &Windows) -> bool {
    let mean = |cosines: &[f64]| {
        let known: Vec<f64> = cosines.iter().copied().filter(|c| c.is_finite()).collect();
        (known.len() >= MIN_MOVING_WINDOWS)
            .then(|| (known.iter().sum::<f64>() / known.len() as f64).abs())
    };
    let [radians, degrees] = &windows.heading_cos;
    let along = matches!((mean(radians), mean(degrees)), (Some(r), Some(d)) if d > 0.8 && r < 0.5);
    // A yaw in radians may exceed a turn, but then it has no jumps of 360.
    windows.largest_yaw > TAU && (along || windows.yaw_jumps > 0)
}

/// A finding if the two sources are equal up to a known factor.
fn known_factor(robot: &str, pair: &SourcePair<'_>) -> Option<Finding> {
    let similarity = similarity(pair.a, pair.b)?;
    if similarity.cosine.abs() < MIN_SIMILARITY {
        return None;
    }
    let size = similarity.factor.abs();
    let is_near = |known: f64| (size / known).ln().abs() < MAX_LN_DEVIATION;
    let (_, meaning) = pair.factors.iter().find(|(known, _)| is_near(*known))?;
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
