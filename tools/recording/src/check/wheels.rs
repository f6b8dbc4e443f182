//! Swapped or reversed wheels, and a pose or command that runs the other way.

use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::{agreement, combine};
use crate::recording::Robot;

/// From here on two lists say the same (cosine).
const SAME: f64 = 0.7;

/// Who says how the robot moves, most trusted first.
struct Witness<'a> {
    name: &'static str,
    v: &'a [f64],
    w: &'a [f64],
}

/// Findings about sides and signs.
pub(super) fn of(robot: &Robot, windows: &Windows, findings: &mut Vec<Finding>) {
    let mut add = |(severity, id, statement, remedy): Verdict| {
        findings.push(Finding::new(severity, &robot.name, id, statement, remedy));
    };
    let witnesses = [
        Witness {
            name: "pose",
            v: &windows.pose_v,
            w: &windows.pose_w,
        },
        Witness {
            name: "command",
            v: &windows.command_v,
            w: &windows.command_w,
        },
        Witness {
            name: "odometry and gyro",
            v: &windows.odometry_v,
            w: &windows.gyro_w,
        },
    ];
    witnesses
        .iter()
        .filter_map(|witness| sides(windows, witness))
        .for_each(&mut add);
    opposite_signs(windows).into_iter().for_each(&mut add);
    crossed_commands(windows).into_iter().for_each(&mut add);
}

/// Sources of the same quantity that run against each other.
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
    let against = |a: &[f64], b: &[f64]| agreement(a, b).is_some_and(|a| a.cosine < -SAME);
    let verdict = |first: &str, second: &str, what: &str| {
        let statement = format!("{first} and {second} have opposite {what}");
        let remedy = "turn the sign of the wrong one";
        (Severity::Error, "opposite_signs", statement, remedy)
    };
    pairs
        .iter()
        .filter(|(_, a, _, b, _)| against(a, b))
        .map(|(first, _, second, _, what)| verdict(first, second, what))
        .collect()
}

/// Each wheel follows the other one's command clearly better than its own.
fn crossed_commands(windows: &Windows) -> Option<Verdict> {
    let follows = |a: &[f64], b: &[f64]| agreement(a, b).map_or(0.0, |a| a.cosine);
    let (right, left) = (&windows.wheel_right, &windows.wheel_left);
    let (to_right, to_left) = (&windows.command_right, &windows.command_left);
    let straight = follows(right, to_right).min(follows(left, to_left));
    let crossed = follows(right, to_left).min(follows(left, to_right));
    (crossed > (straight + 0.2).max(SAME)).then(|| {
        let statement = "each wheel follows the other one's command".to_owned();
        let remedy = "swap right and left in one of the two";
        (Severity::Error, "wheels_swapped", statement, remedy)
    })
}

/// Severity, id, statement and remedy.
type Verdict = (Severity, &'static str, String, &'static str);

/// How the wheels' sum and difference go with the witness's speed and yaw rate.
fn sides(windows: &Windows, witness: &Witness<'_>) -> Option<Verdict> {
    let sum = combine(&windows.wheel_right, &windows.wheel_left, |r, l| r + l);
    let difference = combine(&windows.wheel_right, &windows.wheel_left, |r, l| r - l);
    let cosine = |a: &[f64], b: &[f64]| agreement(a, b).map(|a| a.cosine);
    let sum_v = cosine(&sum, witness.v)?;
    let difference_w = cosine(&difference, witness.w)?;
    let sum_w = cosine(&sum, witness.w)?;
    let difference_v = cosine(&difference, witness.v)?;
    let name = witness.name;
    let numbers = format!("(cosines with the {name}: speed {sum_v:.2}, turning {difference_w:.2})");
    if sum_w.abs() > SAME && difference_v.abs() > SAME && sum_v.abs() < sum_w.abs() {
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
        (v, w) if v < -SAME && w < -SAME => (
            Severity::Error,
            "wheels_reversed",
            "both wheels count backwards".to_owned(),
            "turn the sign of both wheels",
        ),
        (v, w) if v > SAME && w < -SAME => (
            Severity::Error,
            "wheels_swapped",
            "right and left wheel are swapped, or yaw is clockwise".to_owned(),
            "swap the wheels' columns; if the gyro agrees with the wheels, turn the yaw's sign",
        ),
        (v, w) if v < -SAME && w > SAME => (
            Severity::Error,
            "wheels_swapped_and_reversed",
            "the wheels are swapped and count backwards, or the heading points to the back"
                .to_owned(),
            "swap the wheels and turn their signs, or turn the yaw by half a turn",
        ),
        (v, w) if v.abs() < SAME && w.abs() < SAME => (
            Severity::Note,
            "sides_unclear",
            format!("wheels and {name} tell different motions"),
            "look for slip, a wrong clock, or too little motion to tell",
        ),
        _ => return None,
    };
    Some((severity, id, format!("{what} {numbers}"), remedy))
}
