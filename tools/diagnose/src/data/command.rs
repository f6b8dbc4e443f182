//! Wheel speeds that were commanded, whatever recorded them: a twist, the speeds themselves, or voltages by the speed
//! that they give a motor without a load.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::Robot;
use slipstream_sim::Command;

use super::streams;

/// Commanded wheel speeds, [right, left] (rad/s): each holds until the next row.
#[derive(Debug, Clone, Default)]
pub(crate) struct CommandPath {
    pub(crate) times_s: Vec<f64>,
    pub(crate) speeds_rad_s: Vec<[f64; 2]>,
    /// The first command already held before the recording began.
    pub(crate) running: bool,
    /// They are voltages.
    pub(crate) by_volts: bool,
}

/// The commanded wheel speeds of a robot by its nominal radius and track; times count from `origin_s`.
/// `None` without commands, or where they are torques, or voltages of a motor that is not known.
pub(crate) fn commands(robot: &Robot, model: &RobotModel, origin_s: f64) -> Option<CommandPath> {
    let (r, b) = (model.robot.wheel_radius_m, model.robot.half_track_m);
    let mut path = CommandPath::default();
    for (stamp_s, command) in streams::commands(robot) {
        let per_unit = per_unit(&command, model)?;
        path.by_volts |= matches!(command, Command::Voltage { .. });
        let speed = asked(&command, r, b).map(|own| own * per_unit);
        let t_s = stamp_s - origin_s;
        let later = path.times_s.last().is_none_or(|last| t_s > *last);
        // a command that repeats the last one changes nothing
        if later && path.speeds_rad_s.last() != Some(&speed) {
            path.times_s.push(t_s);
            path.speeds_rad_s.push(speed);
        }
    }
    (!path.times_s.is_empty()).then_some(path)
}

impl CommandPath {
    /// Largest commanded speed of a wheel (rad/s).
    pub(crate) fn largest_rad_s(&self) -> f64 {
        let all = self.speeds_rad_s.iter().flatten();
        all.fold(0.0, |most, speed| f64::max(most, speed.abs()))
    }

    /// The command that holds at a time (s); none before the first.
    pub(crate) fn at(&self, time_s: f64) -> Option<[f64; 2]> {
        let next = self.times_s.partition_point(|t_s| *t_s <= time_s);
        Some(self.speeds_rad_s[next.checked_sub(1)?])
    }
}

/// Speed of a wheel (rad/s) for each unit of what a command asks of it; `None` of torques, and of voltages of a motor
/// that is not known.
pub(crate) fn per_unit(command: &Command, model: &RobotModel) -> Option<f64> {
    match command {
        Command::Twist { .. } | Command::Speed { .. } => Some(1.0),
        Command::Voltage { .. } => Some(model.motor.as_ref()?.speed_per_volt()),
        Command::Torque { .. } => None,
    }
}

/// What a command asks of each wheel: N m, V or rad/s.
pub(crate) fn asked(command: &Command, radius_m: f64, half_track_m: f64) -> [f64; 2] {
    match *command {
        Command::Torque { right_nm, left_nm } => [right_nm, left_nm],
        Command::Voltage { right_v, left_v } => [right_v, left_v],
        Command::Speed {
            right_rad_s,
            left_rad_s,
        } => [right_rad_s, left_rad_s],
        Command::Twist { v_m_s, w_rad_s } => {
            let turn = half_track_m * w_rad_s;
            [(v_m_s + turn) / radius_m, (v_m_s - turn) / radius_m]
        }
    }
}
