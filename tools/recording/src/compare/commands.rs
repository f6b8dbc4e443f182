//! Inputs of the simulation: the recorded commands, or the wheel speeds without them.

use slipstream_bus::RobotModel;
use slipstream_sim::{Command as PlantCommand, CommandKind};

use super::wheel_angles::wheel_angles;
use crate::recording::{Command, Robot, Wheels};

/// Commands to the plant, each with the time (s) from which on it holds.
pub(super) type Commands = Vec<(f64, PlantCommand)>;

/// The commands of a robot; `None` if there are fewer than two rows. An empty cell repeats the value
/// of the previous row.
pub(super) fn commands(robot: &Robot, model: &RobotModel) -> Option<Commands> {
    let commands = if robot.command.is_some() {
        recorded_commands(robot)
    } else {
        wheel_speeds(robot, model)
    };
    commands.filter(|rows| rows.len() > 1)
}

fn recorded_commands(robot: &Robot) -> Option<Commands> {
    let command = robot.command.as_ref()?;
    let (a, b, to_command): (_, _, fn(f64, f64) -> PlantCommand) = match &command.values {
        Command::Torque { right_nm, left_nm } => (right_nm, left_nm, |right_nm, left_nm| {
            PlantCommand::Torque { right_nm, left_nm }
        }),
        Command::Voltage { right_v, left_v } => (right_v, left_v, |right_v, left_v| {
            PlantCommand::Voltage { right_v, left_v }
        }),
        Command::WheelSpeed {
            right_rad_s,
            left_rad_s,
        } => (right_rad_s, left_rad_s, speed),
        Command::Twist { v_m_s, w_rad_s } => (v_m_s, w_rad_s, |v_m_s, w_rad_s| {
            PlantCommand::Twist { v_m_s, w_rad_s }
        }),
    };
    Some(zip(&command.t_s, a, b, to_command))
}

fn wheel_speeds(robot: &Robot, model: &RobotModel) -> Option<Commands> {
    let wheels = robot.wheels.as_ref()?;
    if let Wheels::Speed {
        right_rad_s,
        left_rad_s,
    } = &wheels.values
    {
        return Some(zip(&wheels.t_s, right_rad_s, left_rad_s, speed));
    }
    let [right, left] = wheel_angles(robot, model)?;
    let rates = |angles: &[f64]| -> Vec<f64> {
        let times = wheels.t_s.iter().zip(wheels.t_s.iter().skip(1));
        let angles = angles.iter().zip(angles.iter().skip(1));
        let rate = |((t_a, t_b), (a, b)): ((&f64, &f64), (&f64, &f64))| (b - a) / (t_b - t_a);
        times.zip(angles).map(rate).chain([0.0]).collect()
    };
    Some(zip(&wheels.t_s, &rates(&right), &rates(&left), speed))
}

/// The kind of the commands.
pub(super) fn kind(commands: &[(f64, PlantCommand)]) -> CommandKind {
    match commands.first() {
        Some((_, PlantCommand::Torque { .. })) => CommandKind::Torque,
        Some((_, PlantCommand::Voltage { .. })) => CommandKind::Voltage,
        _ => CommandKind::Speed,
    }
}

fn speed(right_rad_s: f64, left_rad_s: f64) -> PlantCommand {
    PlantCommand::Speed {
        right_rad_s,
        left_rad_s,
    }
}

/// Combines two columns; an empty cell repeats the value of the previous row.
fn zip(times: &[f64], a: &[f64], b: &[f64], to_command: fn(f64, f64) -> PlantCommand) -> Commands {
    let mut last = [0.0; 2];
    let rows = times.iter().zip(a.iter().zip(b));
    rows.map(|(t_s, (a, b))| {
        for (last, now) in last.iter_mut().zip([a, b]) {
            if now.is_finite() {
                *last = *now;
            }
        }
        (*t_s, to_command(last[0], last[1]))
    })
    .collect()
}
