//! Encoders that count wrong by a factor: quadrature, gears, counts per revolution, degrees or turns instead
//! of radians.
//!
//! It shows as a known factor between the way of the wheels and that of the pose, or of the command. A
//! diagnosis of speeds measures the factor, so that it is no reason to refuse one; forces need it mended.

use std::f64::consts::TAU;

use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::similarity;

/// Degrees per radian.
const DEGREES: f64 = 360.0 / TAU;
/// Smallest cosine similarity at which wheels and reference follow each other, so that the factor between
/// them is one of counts.
const FOLLOWS: f64 = 0.95;
/// Largest deviation of a factor from a known one, as a natural logarithm. Slip makes any small factor, but no
/// large one.
const NEAR_LN: f64 = 0.05;
const NEAR_LARGE_LN: f64 = 0.25;
/// Logarithm of a factor that is large.
const LARGE_LN: f64 = 3.0;

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

/// Adds a finding to `robot` if the wheels go a known multiple of the way of the pose, or of the command.
/// `windows` are those of all runs of the machine: the slip of one of them is no factor.
pub(super) fn check(robot: &str, windows: &Windows, findings: &mut Vec<Finding>) {
    let (wheels_v, _) = windows.wheel_twist();
    let Some((name, size, meaning)) = known(windows, &wheels_v, true) else {
        return;
    };
    let statement = format!("the wheels go {size:.3} times the way of {name}: {meaning}");
    let remedy = "look up counts per revolution, gear and unit; where speeds are commanded, diagnose \
        measures the factor";
    // a model of forces has no such factor
    let (severity, id) = if windows.drive_right.iter().any(|own| own.is_finite()) {
        (Severity::Error, "units")
    } else {
        (Severity::Warning, "wheel_scale")
    };
    findings.push(Finding::new(severity, robot, id, statement, remedy));
}

/// What the wheels follow, the factor and its meaning, if it is a known one. `with_pose`: the pose's speed means
/// something.
pub(super) fn known(
    windows: &Windows,
    wheels_v: &[f64],
    with_pose: bool,
) -> Option<(&'static str, f64, &'static str)> {
    let pose = ("the pose", &windows.pose_v);
    let command = ("the command", &windows.command_v);
    let sources = [pose, command].into_iter().skip(usize::from(!with_pose));
    let (name, size) = sources.into_iter().find_map(|(name, own)| {
        let found = similarity(wheels_v, own)?;
        (found.cosine.abs() > FOLLOWS).then(|| (name, found.factor.abs()))
    })?;
    let near = |known: f64| {
        let is_large = known.ln().abs() > LARGE_LN;
        (size / known).ln().abs() < if is_large { NEAR_LARGE_LN } else { NEAR_LN }
    };
    let (_, meaning) = KNOWN.iter().find(|(known, _)| near(*known))?;
    Some((name, size, meaning))
}
