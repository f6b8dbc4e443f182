//! Torque or voltage commands against the acceleration of the wheels: swapped, reversed, in mN m.

use slipstream_bus::RobotModel;

use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::{combine, cosine, similarity};
use crate::rows::RobotRows;
use crate::table::StreamKind;

/// Smallest cosine similarity at which command and acceleration count as the same.
const SAME_MOTION: f64 = 0.7;
/// The same for the difference of the wheels, which slip disturbs, if the sum is clear.
const SAME_TURNING: f64 = 0.4;
/// Range of command over (inertia times acceleration) in which the torque is in mN m. Friction can
/// raise the torque above what inertia needs, but not a hundredfold.
const MILLI_RANGE: [f64; 2] = [300.0, 3000.0];
/// Length of the windows (s): short enough to show the response to a command.
pub(super) const WINDOW_S: f64 = 0.2;

/// Adds findings about torque and voltage commands. `windows` have the length [`WINDOW_S`].
pub(super) fn check(
    robot: &RobotRows<'_>,
    model: Option<&RobotModel>,
    windows: &Windows,
    findings: &mut Vec<Finding>,
) {
    let [right, left] = [&windows.drive_right, &windows.drive_left].map(|drive| means(drive));
    let [to_right, to_left] = [&windows.wheel_right, &windows.wheel_left].map(|w| changes(w));
    let sum = |a: &[f64], b: &[f64]| combine(a, b, |a, b| a + b);
    let difference = |a: &[f64], b: &[f64]| combine(a, b, |a, b| a - b);
    let (command, response) = (sum(&right, &left), sum(&to_right, &to_left));
    let along = cosine(&command, &response);
    let about = cosine(&difference(&right, &left), &difference(&to_right, &to_left));
    let (Some(along), Some(about)) = (along, about) else {
        return;
    };
    let mut add = |id, statement: String, remedy: &str| {
        let severity = Severity::Error;
        findings.push(Finding::new(
            severity,
            &robot.robot.name,
            id,
            statement,
            remedy,
        ));
    };
    let numbers = format!("(cosines of both together {along:.2}, of their difference {about:.2})");
    if along < -SAME_MOTION && about < -SAME_TURNING {
        let statement = format!("the wheels speed up against their commands {numbers}");
        add(
            "opposite_signs",
            statement,
            "turn the sign of the wrong one",
        );
    } else if along > SAME_MOTION && about < -SAME_TURNING {
        let statement = format!("each wheel follows the other one's command {numbers}");
        add(
            "wheels_swapped",
            statement,
            "swap right and left in one of the two",
        );
    }
    if let Some(ratio) = torque_over_inertia(robot, model, windows, &command, &response)
        && (MILLI_RANGE[0]..MILLI_RANGE[1]).contains(&ratio)
    {
        let statement = format!(
            "the torques are {ratio:.0} times what the wheels' acceleration takes: they are in mN m"
        );
        add("units", statement, "convert the torques to N m");
    }
}

/// Commanded torque over (inertia times measured acceleration), if the masses are known.
fn torque_over_inertia(
    robot: &RobotRows<'_>,
    model: Option<&RobotModel>,
    windows: &Windows,
    command: &[f64],
    response: &[f64],
) -> Option<f64> {
    let body = &model.filter(|_| windows.wheels_in_rad)?.robot;
    if !robot.has_any(StreamKind::Command, &["torque_right_nm"]) {
        return None;
    }
    let r = body.wheel_radius_m;
    let mass_kg = body.body_mass_kg? + 2.0 * body.wheel_mass_kg?;
    let inertia_kg_m2 = mass_kg * r * r / 2.0 + body.wheel_spin_inertia_kg_m2?;
    let found = similarity(command, response).filter(|found| found.cosine > SAME_MOTION)?;
    Some(found.factor * WINDOW_S / inertia_kg_m2)
}

/// The change from each window to the next.
fn changes(list: &[f64]) -> Vec<f64> {
    let pairs = list.iter().zip(list.iter().skip(1));
    pairs.map(|(a, b)| b - a).collect()
}

/// The mean of each window and the next.
fn means(list: &[f64]) -> Vec<f64> {
    let pairs = list.iter().zip(list.iter().skip(1));
    pairs.map(|(a, b)| (a + b) / 2.0).collect()
}
