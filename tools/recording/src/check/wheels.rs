//! Sides and signs: swapped or reversed wheels, and sources with opposite signs.

use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::{combine, cosine};
use crate::rows::RobotRows;

/// Smallest cosine similarity at which two sources count as the same motion.
const SAME_MOTION: f64 = 0.7;
/// By how much the similarity of a wheel that is taken for the other one, or for its reverse, must exceed
/// that of the wheel as it is.
const CROSSED_MARGIN: f64 = 0.2;

/// A source of the robot's speed and yaw rate.
struct Reference<'a> {
    name: &'static str,
    v: &'a [f64],
    w: &'a [f64],
}

/// Severity, id, statement and remedy of a finding.
type Verdict = (Severity, &'static str, String, &'static str);

/// Adds findings about sides and signs.
pub(super) fn check(robot: &RobotRows<'_>, windows: &Windows, findings: &mut Vec<Finding>) {
    let mut add = |(severity, id, statement, remedy): Verdict| {
        findings.push(Finding::new(
            severity,
            &robot.robot.name,
            id,
            statement,
            remedy,
        ));
    };
    let references = [
        Reference {
            name: "pose",
            v: &windows.pose_v,
            w: &windows.pose_w,
        },
        Reference {
            name: "command",
            v: &windows.command_v,
            w: &windows.command_w,
        },
        Reference {
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
fn opposite_signs(windows: &Windows) -> Vec<Verdict> {
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
fn crossed_commands(windows: &Windows) -> Option<Verdict> {
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

/// Compares sum and difference of the wheel speeds with speed and yaw rate of the reference.
fn sides(windows: &Windows, reference: &Reference<'_>) -> Option<Verdict> {
    let sum = combine(&windows.wheel_right, &windows.wheel_left, |r, l| r + l);
    let difference = combine(&windows.wheel_right, &windows.wheel_left, |r, l| r - l);
    let sum_v = cosine(&sum, reference.v)?;
    let difference_w = cosine(&difference, reference.w)?;
    let sum_w = cosine(&sum, reference.w)?;
    let difference_v = cosine(&difference, reference.v)?;
    let name = reference.name;
    let numbers = format!("(cosines with the {name}: speed {sum_v:.2}, turning {difference_w:.2})");
    // on one circle speed and yaw rate are alike, and so are both readings
    let straight = sum_v.abs().min(difference_w.abs());
    let crossed = sum_w.abs().min(difference_v.abs());
    if crossed > SAME_MOTION && crossed > straight + CROSSED_MARGIN {
        let side = if difference_v > 0.0 { "left" } else { "right" };
        let statement = format!("the {side} wheel counts backwards {numbers}");
        return Some((
            Severity::Error,
            "wheel_reversed",
            statement,
            "turn the sign of that wheel",
        ));
    }
    let (severity, id, what, remedy) = match (sum_v, difference_w) {
        (v, w) if v < -SAME_MOTION && w < -SAME_MOTION => (
            Severity::Error,
            "wheels_reversed",
            "both wheels count backwards".to_owned(),
            "turn the sign of both wheels",
        ),
        (v, w) if v > SAME_MOTION && w < -SAME_MOTION => (
            Severity::Error,
            "wheels_swapped",
            "right and left wheel are swapped, or yaw is clockwise".to_owned(),
            "swap the wheels' columns; if the gyro agrees with the wheels, turn the yaw's sign",
        ),
        (v, w) if v < -SAME_MOTION && w > SAME_MOTION => (
            Severity::Error,
            "wheels_swapped_and_reversed",
            "the wheels are swapped and count backwards, or the heading points to the back"
                .to_owned(),
            "swap the wheels and turn their signs, or turn the yaw by half a turn",
        ),
        (v, w) if v.abs() < SAME_MOTION && w.abs() < SAME_MOTION => (
            Severity::Note,
            "sides_unclear",
            format!("wheels and {name} tell different motions"),
            "look for slip, a wrong clock, or too little motion to tell",
        ),
        _ => return None,
    };
    Some((severity, id, format!("{what} {numbers}"), remedy))
}
