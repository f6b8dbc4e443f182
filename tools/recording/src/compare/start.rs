//! Where it starts.

use slipstream_bus::RobotModel;
use slipstream_sim::{Command as Told, Robot as Plant};

use super::channel::interpolate;
use super::overlay::of_robot;
use super::sensors::tracked_to_com_m;
use super::simulation::simulate;
use crate::recording::Robot;

/// The start is fitted to the poses of so long a time (s).
const START_S: f64 = 0.5;
/// Where c stands at the first complete row of the pose; the origin without one.
fn start_pose(robot: &Robot, model: &RobotModel) -> [f64; 3] {
    let Some(pose) = &robot.pose else {
        return [0.0; 3];
    };
    let yaw = pose.values.yaw_rad.as_deref().unwrap_or_default();
    let mut rows = pose.values.x_m.iter().zip(&pose.values.y_m).zip(yaw);
    let complete = rows.find(|((x, y), yaw)| x.is_finite() && y.is_finite() && yaw.is_finite());
    let Some(((x, y), yaw)) = complete else {
        return [0.0; 3];
    };
    let ahead = tracked_to_com_m(robot, model);
    [x + ahead * yaw.cos(), y + ahead * yaw.sin(), *yaw]
}

/// Where c starts: as the first pose says, then turned and shifted by what is left on average over
/// the first half second, because one pose alone is noisy.
pub(super) fn fit_start(
    plant: &Plant,
    robot: &Robot,
    model: &RobotModel,
    commands: &[(f64, Told)],
) -> [f64; 3] {
    let first = start_pose(robot, model);
    let (Some(pose), Some((from_s, _))) = (&robot.pose, commands.first()) else {
        return first;
    };
    let until_s = from_s.max(pose.t_s.first().copied().unwrap_or(*from_s)) + START_S;
    let run = simulate(plant, robot, first, commands, until_s);
    let channels = of_robot(robot, model, &run);
    let left = |name: &str| -> f64 {
        let Some(channel) = channels.iter().find(|channel| channel.name == name) else {
            return 0.0;
        };
        let early = channel.recorded.iter().filter(|(t_s, _)| *t_s <= until_s);
        let differences: Vec<f64> = early
            .filter_map(|(t_s, value)| Some(value - interpolate(&channel.simulated, *t_s)?))
            .collect();
        differences.iter().sum::<f64>() / (differences.len() as f64).max(1.0)
    };
    let [x_m, y_m, yaw_rad] = first;
    [
        x_m + left("pose x"),
        y_m + left("pose y"),
        yaw_rad + left("pose yaw"),
    ]
}
