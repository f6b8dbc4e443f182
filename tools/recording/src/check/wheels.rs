//! Sides and signs: swapped or reversed wheels, and sources with opposite signs.
//!
//! Asked of all runs of a machine together: in one of them a strong side may drag the other backwards.

use super::assignment::{Assignment, Regression};
use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::cosine;

/// Smallest cosine similarity at which two sources count as the same motion.
const SAME_MOTION: f64 = 0.7;
/// By how much the similarity of a wheel that is taken for the other one, or for its reverse, must exceed
/// that of the wheel as it is.
const CROSSED_MARGIN: f64 = 0.2;
/// Share of the motion that even the best assignment leaves, from which on wheels and reference tell
/// different motions.
const UNCLEAR: f64 = 0.75;

/// A source of the robot's speed and yaw rate.
struct MotionSource<'a> {
    name: &'static str,
    v: &'a [f64],
    w: &'a [f64],
}

/// Severity, id, statement and remedy of a finding.
type WheelFinding = (Severity, &'static str, String, &'static str);

/// Adds findings about sides and signs to `robot`. `windows` are those of all runs of the machine.
pub(super) fn check(robot: &str, windows: &Windows, findings: &mut Vec<Finding>) {
    let mut add = |(severity, id, statement, remedy): WheelFinding| {
        findings.push(Finding::new(severity, robot, id, statement, remedy));
    };
    let references = [
        MotionSource {
            name: "pose",
            v: &windows.pose_v,
            w: &windows.pose_w,
        },
        MotionSource {
            name: "command",
            v: &windows.command_v,
            w: &windows.command_w,
        },
        MotionSource {
            name: "odometry and gyro",
            v: &windows.odometry_v,
            w: &windows.gyro_w,
        },
    ];
    references
        .iter()
        .filter_map(|reference| sides(windows, reference))
        .for_each(&mut add);
    opposite_signs(windows).into_iter().for_each(&mut add);
    crossed_commands(windows).into_iter().for_each(&mut add);
}

/// Sources of the same quantity with opposite signs.
fn opposite_signs(windows: &Windows) -> Vec<WheelFinding> {
    let Windows {
        pose_v,
        pose_w,
        gyro_w,
        command_v,
        command_w,
        wheel_right,
        wheel_left,
        command_right,
        command_left,
        ..
    } = windows;
    let pairs = [
        ("pose", pose_v, "command", command_v, "forward speeds"),
        ("pose", pose_w, "command", command_w, "yaw rates"),
        ("pose", pose_w, "gyro", gyro_w, "yaw rates"),
        ("gyro", gyro_w, "command", command_w, "yaw rates"),
        (
            "wheels",
            wheel_right,
            "command",
            command_right,
            "right wheel's speeds",
        ),
        (
            "wheels",
            wheel_left,
            "command",
            command_left,
            "left wheel's speeds",
        ),
    ];
    let are_opposite = |a: &[f64], b: &[f64]| cosine(a, b).is_some_and(|c| c < -SAME_MOTION);
    let verdict = |first: &str, second: &str, what: &str| {
        let statement = format!("{first} and {second} have opposite {what}");
        let remedy = "turn the sign of the wrong one";
        (Severity::Error, "opposite_signs", statement, remedy)
    };
    pairs
        .iter()
        .filter(|(_, a, _, b, _)| are_opposite(a, b))
        .map(|(first, _, second, _, what)| verdict(first, second, what))
        .collect()
}

/// Whether each wheel follows the command of the other wheel clearly better than its own.
fn crossed_commands(windows: &Windows) -> Option<WheelFinding> {
    let follows = |a: &[f64], b: &[f64]| cosine(a, b).unwrap_or(0.0);
    let (right, left) = (&windows.wheel_right, &windows.wheel_left);
    let (command_right, command_left) = (&windows.command_right, &windows.command_left);
    let straight = follows(right, command_right).min(follows(left, command_left));
    let crossed = follows(right, command_left).min(follows(left, command_right));
    (crossed > (straight + CROSSED_MARGIN).max(SAME_MOTION)).then(|| {
        let statement = "each wheel follows the other one's command".to_owned();
        let remedy = "swap right and left in one of the two";
        (Severity::Error, "wheels_swapped", statement, remedy)
    })
}

/// The assignment of sides and signs that the reference tells, where it is another than the given one.
fn sides(windows: &Windows, reference: &MotionSource<'_>) -> Option<WheelFinding> {
    let name = reference.name;
    let wheels: [&[f64]; 2] = [&windows.wheel_right, &windows.wheel_left];
    let half_track_m = windows.size_m.map(|[_, b]| b);
    let regression = Regression::new(wheels, [reference.v, reference.w], half_track_m)?;
    let Some(other) = regression.other() else {
        return (regression.least_left() > UNCLEAR).then(|| {
            let statement = format!("wheels and {name} tell different motions");
            let remedy = "look for slip, a wrong clock, or too little motion to tell";
            (Severity::Note, "sides_unclear", statement, remedy)
        });
    };
    let (id, what, remedy) = words(other);
    let statement = format!("{what} (by the {name})");
    Some((Severity::Error, id, statement, remedy))
}

/// Id, statement and remedy of an assignment that is not the given one.
fn words(own: Assignment) -> (&'static str, &'static str, &'static str) {
    match (own.swapped, own.backwards) {
        (false, [false, true]) => (
            "wheel_reversed",
            "the left wheel counts backwards",
            "turn the sign of that wheel",
        ),
        (false, [true, false]) => (
            "wheel_reversed",
            "the right wheel counts backwards",
            "turn the sign of that wheel",
        ),
        (false, _) => (
            "wheels_reversed",
            "both wheels count backwards",
            "turn the sign of both wheels",
        ),
        (true, [false, false]) => (
            "wheels_swapped",
            "right and left wheel are swapped, or yaw is clockwise",
            "swap the wheels' columns; if the gyro agrees with the wheels, turn the yaw's sign",
        ),
        (true, [true, true]) => (
            "wheels_swapped_and_reversed",
            "the wheels are swapped and count backwards, or the heading points to the back",
            "swap the wheels and turn their signs, or turn the yaw by half a turn",
        ),
        (true, _) => (
            "wheels_swapped_and_reversed",
            "the wheels are swapped and one of them counts backwards",
            "swap the wheels' columns, then turn the sign of the wheel that still turns against the motion",
        ),
    }
}
