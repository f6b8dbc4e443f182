//! Swapped or reversed wheels, and a pose or command that runs the other way.

use super::motion::{Windows, agreement, combine};
use super::{Finding, Severity};
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
    let mut add = |severity, id, statement: String, remedy: &str| {
        findings.push(Finding::new(severity, &robot.name, id, statement, remedy));
    };
    if !windows.wheel_right.is_empty() {
        for witness in &witnesses {
            match sides(windows, witness) {
                Some((id, statement, remedy)) if id.is_empty() => {
                    add(Severity::Note, "sides_unclear", statement, remedy);
                }
                Some((id, statement, remedy)) => add(Severity::Error, id, statement, remedy),
                None => {}
            }
        }
    }
    let opposite = |a: &[f64], b: &[f64]| agreement(a, b).is_some_and(|a| a.cosine < -SAME);
    let pairs = [
        (
            "pose",
            &windows.pose_v,
            "command",
            &windows.command_v,
            "forward speeds",
        ),
        (
            "pose",
            &windows.pose_w,
            "command",
            &windows.command_w,
            "yaw rates",
        ),
        (
            "pose",
            &windows.pose_w,
            "gyro",
            &windows.gyro_w,
            "yaw rates",
        ),
        (
            "gyro",
            &windows.gyro_w,
            "command",
            &windows.command_w,
            "yaw rates",
        ),
        (
            "wheels",
            &windows.wheel_right,
            "command",
            &windows.command_right,
            "right wheel's speeds",
        ),
        (
            "wheels",
            &windows.wheel_left,
            "command",
            &windows.command_left,
            "left wheel's speeds",
        ),
    ];
    for (first, a, second, b, what) in pairs {
        if opposite(a, b) {
            let statement = format!("{first} and {second} have opposite {what}");
            add(
                Severity::Error,
                "opposite_signs",
                statement,
                "turn the sign of the wrong one",
            );
        }
    }
    let crossed = |a: &[f64], b: &[f64]| agreement(a, b).map_or(0.0, |a| a.cosine);
    let (right, left) = (&windows.wheel_right, &windows.wheel_left);
    let (to_right, to_left) = (&windows.command_right, &windows.command_left);
    let straight = crossed(right, to_right).min(crossed(left, to_left));
    if crossed(right, to_left).min(crossed(left, to_right)) > (straight + 0.2).max(SAME) {
        let statement = "each wheel follows the other one's command".to_owned();
        add(
            Severity::Error,
            "wheels_swapped",
            statement,
            "swap right and left in one of the two",
        );
    }
}

type Verdict = (&'static str, String, &'static str);

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
        return Some((
            "wheel_reversed",
            format!("the {side} wheel counts backwards {numbers}"),
            "turn the sign of that wheel",
        ));
    }
    match (sum_v, difference_w) {
        (v, w) if v < -SAME && w < -SAME => Some((
            "wheels_reversed",
            format!("both wheels count backwards {numbers}"),
            "turn the sign of both wheels",
        )),
        (v, w) if v > SAME && w < -SAME => Some((
            "wheels_swapped",
            format!("right and left wheel are swapped, or yaw is clockwise {numbers}"),
            "swap the wheels' columns; if the gyro agrees with the wheels, turn the yaw's sign",
        )),
        (v, w) if v < -SAME && w > SAME => Some((
            "wheels_swapped_and_reversed",
            format!(
                "the wheels are swapped and count backwards, or the heading points to the back {numbers}"
            ),
            "swap the wheels and turn their signs, or turn the yaw by half a turn",
        )),
        (v, w) if v.abs() < SAME && w.abs() < SAME => Some((
            "",
            format!("wheels and {name} tell different motions {numbers}"),
            "look for slip, a wrong clock, or too little motion to tell",
        )),
        _ => None,
    }
}
