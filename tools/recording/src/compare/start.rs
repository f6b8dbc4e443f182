//! Start pose of the simulation, fitted to the first recorded poses.

use slipstream_bus::RobotModel;
use slipstream_sim::{Command as PlantCommand, Robot as Plant};

use super::channel::interpolate;
use super::overlay::{channels, tracked_point_to_com_m};
use super::simulation::simulate;
use crate::recording::Robot;

/// Duration of the poses to which the start pose is fitted (s).
const FIT_DURATION_S: f64 = 0.5;
/// Corrections of the start pose: a turned or shifted tracking point moves with the heading.
const CORRECTIONS: usize = 3;

/// The start pose of c: the first recorded pose, corrected by the mean difference between recorded and
/// simulated poses over the first half second, because a single pose is noisy.
pub(super) fn fit_start_pose(
    plant: &Plant,
    robot: &Robot,
    model: &RobotModel,
    commands: &[(f64, PlantCommand)],
) -> [f64; 3] {
    let first = first_pose(robot, model);
    let (Some(pose), Some((from_s, _))) = (&robot.pose, commands.first()) else {
        return first;
    };
    let until_s = from_s.max(pose.t_s.first().copied().unwrap_or(*from_s)) + FIT_DURATION_S;
    (0..CORRECTIONS).fold(first, |start, _| {
        corrected(plant, robot, model, commands, start, until_s)
    })
}

/// A start pose, corrected by what recorded and simulated poses differ until `until_s`.
fn corrected(
    plant: &Plant,
    robot: &Robot,
    model: &RobotModel,
    commands: &[(f64, PlantCommand)],
    start: [f64; 3],
    until_s: f64,
) -> [f64; 3] {
    let samples = simulate(plant, robot, start, commands, until_s);
    let channels = channels(robot, model, &samples);
    let mean_difference = |name: &str| -> f64 {
        let Some(channel) = channels.iter().find(|channel| channel.name == name) else {
            return 0.0;
        };
        let early = channel.recorded.iter().filter(|(t_s, _)| *t_s <= until_s);
        let differences: Vec<f64> = early
            .filter_map(|(t_s, value)| Some(value - interpolate(&channel.simulated, *t_s)?))
            .collect();
        differences.iter().sum::<f64>() / (differences.len() as f64).max(1.0)
    };
    let [x_m, y_m, yaw_rad] = start;
    [
        x_m + mean_difference("pose x"),
        y_m + mean_difference("pose y"),
        yaw_rad + mean_difference("pose yaw"),
    ]
}

/// The pose of c at the first complete row of the pose; the origin if there is none.
fn first_pose(robot: &Robot, model: &RobotModel) -> [f64; 3] {
    let Some(pose) = &robot.pose else {
        return [0.0; 3];
    };
    let yaw = pose.values.yaw_rad.as_deref().unwrap_or_default();
    let mut rows = pose.values.x_m.iter().zip(&pose.values.y_m).zip(yaw);
    let complete = rows.find(|((x, y), yaw)| x.is_finite() && y.is_finite() && yaw.is_finite());
    let Some(((x, y), yaw)) = complete else {
        return [0.0; 3];
    };
    let ahead = tracked_point_to_com_m(robot, model);
    [x + ahead * yaw.cos(), y + ahead * yaw.sin(), *yaw]
}
