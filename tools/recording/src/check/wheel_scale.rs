//! Encoders that count wrong by a factor: quadrature, gears, counts per revolution, degrees or turns instead
//! of radians.
//!
//! It shows as a known factor between the way of the wheels and that of the pose, or of the command. A
//! diagnosis of speeds measures the factor, so that it is no reason to refuse one; forces need it mended.

use std::f64::consts::TAU;

use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::similarity;
use crate::rows::RobotRows;
use crate::table::StreamKind;

/// Degrees per radian.
const DEGREES: f64 = 360.0 / TAU;
/// Smallest cosine similarity at which wheels and reference follow each other, so that the factor between
/// them is one of counts.
const FOLLOWS: f64 = 0.9;
/// Largest deviation of a factor from a known one, as a natural logarithm: less than half of what lies
/// between two of them (2 pi and 4: 0.45).
const NEAR_LN: f64 = 0.15;

/// Known factors of what wheels measure over what they do, with what makes them.
const KNOWN: [(f64, &str); 10] = [
    (
        2.0,
        "encoders count two edges (quadrature x2), or a gear of 2 is left out",
    ),
    (
        4.0,
        "encoders count four edges (quadrature x4), or a gear of 4 is left out",
    ),
    (
        0.5,
        "a diameter in place of a radius, encoders that count one edge of two, or a gear of 2",
    ),
    (
        0.25,
        "encoders count one edge of four, or a gear of 4 is counted twice",
    ),
    (DEGREES, "the wheels's angles are in degrees"),
    (
        1.0 / DEGREES,
        "the wheels's angles were converted from degrees to radians once too often",
    ),
    (
        TAU,
        "the wheels's angles were multiplied by 2 pi once too often",
    ),
    (1.0 / TAU, "the wheels's angles are in turns"),
    (
        360.0,
        "the wheels's angles are in degrees where turns are expected",
    ),
    (
        1.0 / 360.0,
        "the wheels's angles are in turns where degrees are expected",
    ),
];

/// A finding if the wheels go a known multiple of the way of the pose, or of the command.
pub(super) fn check(
    robot: &RobotRows<'_>,
    windows: &Windows,
    wheels_v: &[f64],
    with_pose: bool,
) -> Option<Finding> {
    let pose = ("the pose", &windows.pose_v);
    let command = ("the command", &windows.command_v);
    let sources = [pose, command].into_iter().skip(usize::from(!with_pose));
    let (name, size) = sources.into_iter().find_map(|(name, own)| {
        let found = similarity(wheels_v, own)?;
        (found.cosine.abs() > FOLLOWS).then(|| (name, found.factor.abs()))
    })?;
    let near = |known: f64| (size / known).ln().abs() < NEAR_LN;
    let (_, meaning) = KNOWN.iter().find(|(known, _)| near(*known))?;
    let statement = format!("the wheels go {size:.3} times the way of {name}: {meaning}");
    let remedy = "look up counts per revolution, gear and unit; where speeds are commanded, diagnose \
        measures the factor";
    let (severity, id) = if is_forced(robot) {
        (Severity::Error, "units")
    } else {
        (Severity::Warning, "wheel_scale")
    };
    Some(Finding::new(
        severity,
        &robot.robot.name,
        id,
        statement,
        remedy,
    ))
}

/// Whether torques or voltages are commanded: a model of forces has no such factor.
fn is_forced(robot: &RobotRows<'_>) -> bool {
    robot.has_any(StreamKind::Command, &["torque_right_nm", "voltage_right_v"])
}
