//! What drives the simulation.

use slipstream_bus::RobotModel;
use slipstream_sim::{Command as Told, CommandKind};

use super::sensors::wheel_angles;
use crate::recording::{Command, Robot, Wheels};

/// What the plant is told, from when (s).
pub(super) type Commands = Vec<(f64, Told)>;

/// The recorded commands; without them the wheels' speeds. Empty cells repeat the row before.
pub(super) fn commands(robot: &Robot, model: &RobotModel) -> Option<Commands> {
    if let Some(command) = &robot.command {
        let (a, b, told): (_, _, fn(f64, f64) -> Told) = match &command.values {
            Command::Torque { right_nm, left_nm } => (right_nm, left_nm, |right_nm, left_nm| {
                Told::Torque { right_nm, left_nm }
            }),
            Command::Voltage { right_v, left_v } => (right_v, left_v, |right_v, left_v| {
                Told::Voltage { right_v, left_v }
            }),
            Command::WheelSpeed {
                right_rad_s,
                left_rad_s,
            } => (right_rad_s, left_rad_s, speed),
            Command::Twist { v_m_s, w_rad_s } => (v_m_s, w_rad_s, |v_m_s, w_rad_s| Told::Twist {
                v_m_s,
                w_rad_s,
            }),
        };
        return Some(pairs(&command.t_s, a, b, told)).filter(|rows| rows.len() > 1);
    }
    let wheels = robot.wheels.as_ref()?;
    if let Wheels::Speed {
        right_rad_s,
        left_rad_s,
    } = &wheels.values
    {
        return Some(pairs(&wheels.t_s, right_rad_s, left_rad_s, speed)).filter(|r| r.len() > 1);
    }
    let [right, left] = wheel_angles(robot, model)?;
    let rate = |angle: &[f64]| -> Vec<f64> {
        let steps = wheels.t_s.iter().zip(wheels.t_s.iter().skip(1));
        let turns = angle.iter().zip(angle.iter().skip(1));
        let rate = |((t_a, t_b), (a, b)): ((&f64, &f64), (&f64, &f64))| (b - a) / (t_b - t_a);
        steps.zip(turns).map(rate).chain([0.0]).collect()
    };
    Some(pairs(&wheels.t_s, &rate(&right), &rate(&left), speed)).filter(|rows| rows.len() > 1)
}

/// What the commands set at the wheels.
pub(super) fn kind(commands: &[(f64, Told)]) -> CommandKind {
    match commands.first() {
        Some((_, Told::Torque { .. })) => CommandKind::Torque,
        Some((_, Told::Voltage { .. })) => CommandKind::Voltage,
        _ => CommandKind::Speed,
    }
}

fn speed(right_rad_s: f64, left_rad_s: f64) -> Told {
    Told::Speed {
        right_rad_s,
        left_rad_s,
    }
}

fn pairs(times: &[f64], a: &[f64], b: &[f64], told: fn(f64, f64) -> Told) -> Commands {
    let mut last = [0.0; 2];
    let rows = times.iter().zip(a.iter().zip(b));
    rows.map(|(t_s, (a, b))| {
        for (last, now) in last.iter_mut().zip([a, b]) {
            if now.is_finite() {
                *last = *now;
            }
        }
        (*t_s, told(last[0], last[1]))
    })
    .collect()
}
