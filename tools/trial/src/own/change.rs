//! Changes that can be put into data exactly.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{Command, Robot, Wheels};
use slipstream_sim::effects::{Role, find};

use super::rows::pair;

/// Whether a parameter of an effect is a factor: 1 without the effect.
pub(super) fn is_factor(effect: &str, parameter: &str) -> bool {
    let info = find(effect).and_then(|info| info.parameter(parameter));
    info.is_some_and(|own| own.role == Role::Factor)
}

/// A change, by the effect of the catalogue that it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// Poses are stamped later (s).
    PoseLate(f64),
    /// The gyro is stamped later (s).
    GyroLate(f64),
    /// Wheels are stamped later (s).
    WheelsLate(f64),
    /// The clock of the poses runs fast (s/s).
    PoseClock(f64),
    /// The reference sits further forward and further left (m).
    Offset([f64; 2]),
    /// The reference is turned to the left (rad).
    Turned(f64),
    /// The right and the left wheel are larger by these factors.
    Radius([f64; 2]),
    /// The right and the left encoder count more by these factors.
    Counts([f64; 2]),
    /// Commands act later (s).
    CommandLate(f64),
    /// Commands act by this factor.
    Gain(f64),
    /// Commands lose a constant size at the wheels (rad/s).
    DeadZone(f64),
}

impl Change {
    /// The effect of the catalogue.
    pub fn effect(&self) -> &'static str {
        match self {
            Self::PoseLate(_) => "pose_latency",
            Self::GyroLate(_) => "imu_latency",
            Self::WheelsLate(_) => "wheels_latency",
            Self::PoseClock(_) => "clock_drift",
            Self::Offset(_) | Self::Turned(_) => "pose_offset",
            Self::Radius(_) => "wheel_radius",
            Self::Counts(_) => "encoder_scale",
            Self::CommandLate(_) => "actuator_delay",
            Self::Gain(_) => "motor_gain",
            Self::DeadZone(_) => "command_dead_zone",
        }
    }

    /// Names and sizes of its parameters: differences, or factors where the parameter is one.
    pub fn parameters(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::PoseLate(s) | Self::GyroLate(s) | Self::WheelsLate(s) => vec![("latency_s", s)],
            Self::PoseClock(rate) => vec![("rate", rate)],
            Self::Offset([x, y]) => vec![("x_m", x), ("y_m", y)],
            Self::Turned(yaw) => vec![("yaw_rad", yaw)],
            Self::Radius([right, left]) | Self::Counts([right, left]) => {
                vec![("right_scale", right), ("left_scale", left)]
            }
            Self::CommandLate(s) => vec![("delay_s", s)],
            Self::Gain(gain) => vec![("right", gain), ("left", gain)],
            Self::DeadZone(speed) => vec![("speed_rad_s", speed)],
        }
    }

    /// Effects and parameters of the catalogue that have to be seen for a parameter to be: encoders that count
    /// wrong are seen as a gain of the drive and as a radius, late wheels as a delay and as late references.
    pub(super) fn shown_by(&self, parameter: &str) -> Vec<(&'static str, &'static str)> {
        match (self, parameter) {
            (Self::Counts(_), "right_scale") => {
                vec![("motor_gain", "right"), ("wheel_radius", "right_scale")]
            }
            (Self::Counts(_), _) => {
                vec![("motor_gain", "left"), ("wheel_radius", "left_scale")]
            }
            (Self::WheelsLate(_), _) => vec![
                ("actuator_delay", "delay_s"),
                ("pose_latency", "latency_s"),
                ("imu_latency", "latency_s"),
            ],
            _ => {
                let mut all = self.parameters().into_iter();
                let own = all.find(|(name, _)| *name == parameter);
                own.map(|(name, _)| (self.effect(), name))
                    .into_iter()
                    .collect()
            }
        }
    }

    /// How far each parameter is from nothing.
    pub(super) fn distances(&self) -> Vec<(&'static str, f64)> {
        let distance = |(name, value): (&'static str, f64)| {
            let nothing = f64::from(u8::from(is_factor(self.effect(), name)));
            (name, (value - nothing).abs())
        };
        self.parameters().into_iter().map(distance).collect()
    }

    /// How far the parameter that changes most is from nothing.
    pub fn size(&self) -> (&'static str, f64) {
        let most = self.distances().into_iter();
        let most = most.max_by(|a, b| a.1.total_cmp(&b.1));
        most.unwrap_or(("", 0.0))
    }

    /// Effects that the data of a robot cannot tell from it, whatever the program says.
    pub fn look_alikes(&self, robot: &Robot) -> Vec<String> {
        let has_wheels = robot.wheels.is_some();
        let commanded = robot.command.is_some();
        let names: &[&str] = match self {
            Self::Radius(_) if has_wheels && !commanded => &["encoder_scale", "slip_ratio"],
            Self::Gain(_) if !has_wheels => &["wheel_radius", "slip_ratio"],
            Self::PoseLate(_) if !has_wheels => &["actuator_delay"],
            Self::CommandLate(_) if !has_wheels => &["pose_latency"],
            Self::Counts(_) if robot.pose.is_none() => {
                &["motor_gain", "wheel_radius", "track_width"]
            }
            Self::WheelsLate(_) if robot.pose.is_none() && robot.imu.is_none() => {
                &["actuator_delay"]
            }
            Self::Gain(_) if robot.pose.is_none() && robot.imu.is_none() => &["encoder_scale"],
            Self::CommandLate(_) if robot.pose.is_none() && robot.imu.is_none() => {
                &["wheels_latency"]
            }
            _ => &[],
        };
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    /// Puts the change into the data of a robot.
    pub fn apply(&self, robot: &mut Robot, model: &RobotModel) {
        match *self {
            Self::PoseLate(s) => shift(robot.pose.iter_mut().flat_map(|own| &mut own.t_s), s),
            Self::GyroLate(s) => shift(robot.imu.iter_mut().flat_map(|own| &mut own.t_s), s),
            Self::WheelsLate(s) => shift(robot.wheels.iter_mut().flat_map(|own| &mut own.t_s), s),
            // the response is later against its command
            Self::CommandLate(s) => {
                shift(robot.command.iter_mut().flat_map(|own| &mut own.t_s), -s);
            }
            Self::PoseClock(rate) => {
                let times = robot.pose.iter_mut().flat_map(|own| &mut own.t_s);
                times.for_each(|t_s| *t_s *= 1.0 + rate);
            }
            Self::Offset(offset) => moved(robot, offset),
            Self::Turned(yaw) => {
                let poses = robot.pose.iter_mut();
                let yaws = poses
                    .filter_map(|own| own.values.yaw_rad.as_mut())
                    .flatten();
                yaws.for_each(|own| *own = wrapped(*own + yaw));
            }
            // a larger wheel turns less on the same way
            Self::Radius([right, left]) => counted(robot, [1.0 / right, 1.0 / left]),
            Self::Counts(factors) => counted(robot, factors),
            Self::Gain(gain) => {
                if let Some(command) = &mut robot.command {
                    for column in pair(&mut command.values) {
                        column.iter_mut().for_each(|own| *own /= gain);
                    }
                }
            }
            Self::DeadZone(speed) => raised(robot, model, speed),
        }
    }
}

fn shift<'a>(times: impl Iterator<Item = &'a mut f64>, by_s: f64) {
    times.for_each(|t_s| *t_s += by_s);
}

fn wrapped(angle: f64) -> f64 {
    let (sin, cos) = angle.sin_cos();
    sin.atan2(cos)
}

fn moved(robot: &mut Robot, [dx, dy]: [f64; 2]) {
    let Some(pose) = robot.pose.as_mut().map(|own| &mut own.values) else {
        return;
    };
    let Some(yaws) = &pose.yaw_rad else { return };
    for ((x, y), yaw) in pose.x_m.iter_mut().zip(&mut pose.y_m).zip(yaws) {
        let (sin, cos) = yaw.sin_cos();
        *x += dx * cos - dy * sin;
        *y += dx * sin + dy * cos;
    }
}

fn counted(robot: &mut Robot, factors: [f64; 2]) {
    let Some(wheels) = robot.wheels.as_mut().map(|own| &mut own.values) else {
        return;
    };
    match wheels {
        Wheels::Ticks { right, left } => {
            for (column, factor) in [right, left].into_iter().zip(factors) {
                for own in column.iter_mut().flatten() {
                    *own = (*own as f64 * factor).round() as i64;
                }
            }
        }
        Wheels::Angle {
            right_rad: right,
            left_rad: left,
        }
        | Wheels::Speed {
            right_rad_s: right,
            left_rad_s: left,
        } => {
            for (column, factor) in [right, left].into_iter().zip(factors) {
                column.iter_mut().for_each(|own| *own *= factor);
            }
        }
    }
}

/// Raises what is commanded at each wheel, so that the response is what it would be without `speed`.
fn raised(robot: &mut Robot, model: &RobotModel, speed: f64) {
    let Some(command) = robot.command.as_mut().map(|own| &mut own.values) else {
        return;
    };
    let [r, b] = [model.robot.wheel_radius_m, model.robot.half_track_m];
    let more = |wheel: f64| {
        if wheel == 0.0 {
            0.0
        } else {
            wheel + speed.copysign(wheel)
        }
    };
    let is_twist = matches!(command, Command::Twist { .. });
    let [first, second] = pair(command);
    for (a, c) in first.iter_mut().zip(second) {
        if is_twist {
            let [right, left] = [more((*a + b * *c) / r), more((*a - b * *c) / r)];
            *a = r * (right + left) / 2.0;
            *c = r * (right - left) / (2.0 * b);
        } else {
            (*a, *c) = (more(*a), more(*c));
        }
    }
}
