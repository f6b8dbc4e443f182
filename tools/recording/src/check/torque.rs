//! Torques or voltages against what the wheels do after them: swapped, reversed, in mN m.

use slipstream_bus::RobotModel;

use super::motion::{Windows, cut};
use super::report::{Finding, Severity};
use super::similarity::{agreement, combine};
use crate::recording::{Command, Robot};

/// From here on two lists say the same (cosine).
const SAME: f64 = 0.7;
/// The same for what slip disturbs, beside a sum that says it.
const CLEAR: f64 = 0.4;
/// Torque over inertia times acceleration, from where on it is in mN m. Friction asks for more torque
/// than inertia does, but not for hundreds of times as much.
const MILLI: [f64; 2] = [300.0, 3000.0];

/// Length of the windows (s): short enough for what a command changes to be seen.
const WINDOW_S: f64 = 0.2;

/// Findings about the commands of torque or voltage.
pub(super) fn of(robot: &Robot, model: Option<&RobotModel>, findings: &mut Vec<Finding>) {
    let windows = &cut(robot, model, WINDOW_S);
    let [right, left] = [&windows.drive_right, &windows.drive_left].map(|drive| between(drive));
    let [to_right, to_left] = [&windows.wheel_right, &windows.wheel_left].map(|w| changes(w));
    let cosine = |a: &[f64], b: &[f64]| agreement(a, b).map(|a| a.cosine);
    let sum = |a: &[f64], b: &[f64]| combine(a, b, |a, b| a + b);
    let difference = |a: &[f64], b: &[f64]| combine(a, b, |a, b| a - b);
    let (asked, turned) = (sum(&right, &left), sum(&to_right, &to_left));
    let along = cosine(&asked, &turned);
    let about = cosine(&difference(&right, &left), &difference(&to_right, &to_left));
    let (Some(along), Some(about)) = (along, about) else {
        return;
    };
    let mut add = |id, statement: String, remedy: &str| {
        let severity = Severity::Error;
        findings.push(Finding::new(severity, &robot.name, id, statement, remedy));
    };
    let numbers = format!("(cosines of both together {along:.2}, of their difference {about:.2})");
    if along < -SAME && about < -CLEAR {
        let statement = format!("the wheels speed up against their commands {numbers}");
        add(
            "opposite_signs",
            statement,
            "turn the sign of the wrong one",
        );
    } else if along > SAME && about < -CLEAR {
        let statement = format!("each wheel follows the other one's command {numbers}");
        add(
            "wheels_swapped",
            statement,
            "swap right and left in one of the two",
        );
    }
    if let Some(ratio) = over_inertia(robot, model, windows, &asked, &turned)
        && (MILLI[0]..MILLI[1]).contains(&ratio)
    {
        let statement = format!(
            "the torques are {ratio:.0} times what the wheels' acceleration takes: they are in mN m"
        );
        add("units", statement, "convert the torques to N m");
    }
}

/// Torque over what inertia asks for at the acceleration that was seen, where masses are known.
fn over_inertia(
    robot: &Robot,
    model: Option<&RobotModel>,
    windows: &Windows,
    asked: &[f64],
    turned: &[f64],
) -> Option<f64> {
    let body = &model.filter(|_| windows.wheels_in_rad)?.robot;
    let command = robot.command.as_ref()?;
    if !matches!(command.values, Command::Torque { .. }) {
        return None;
    }
    let r = body.wheel_radius_m;
    let mass_kg = body.body_mass_kg? + 2.0 * body.wheel_mass_kg?;
    let inertia_kg_m2 = mass_kg * r * r / 2.0 + body.wheel_spin_inertia_kg_m2?;
    let found = agreement(asked, turned).filter(|found| found.cosine > SAME)?;
    Some(found.factor * WINDOW_S / inertia_kg_m2)
}

/// The change from each window to the next.
fn changes(list: &[f64]) -> Vec<f64> {
    let pairs = list.iter().zip(list.iter().skip(1));
    pairs.map(|(a, b)| b - a).collect()
}

/// The mean of each window and the next.
fn between(list: &[f64]) -> Vec<f64> {
    let pairs = list.iter().zip(list.iter().skip(1));
    pairs.map(|(a, b)| (a + b) / 2.0).collect()
}
