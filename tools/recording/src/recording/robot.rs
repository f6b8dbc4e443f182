//! One robot of a recording: its streams and the description of its sensors.

use slipstream_bus::RobotModel;

use super::streams::{Command, Imu, Motor, Odometry, Pose, Stream, Wheels};

/// The streams of one robot and the description of its sensors.
#[derive(Debug, Clone, Default)]
pub struct Robot {
    /// Name of the robot and of its folder (see [`is_robot_name`]).
    pub name: String,
    /// Encoder counts per wheel revolution, for wheels recorded as ticks. Overrides the model's value.
    pub encoder_counts_per_rev: Option<f64>,
    /// The point whose pose is recorded. `None` means the centre of mass.
    pub pose_point: Option<PosePoint>,
    /// The quantity that the accelerometer measures. `None` means specific force.
    pub imu_kind: Option<ImuKind>,
    /// Standard deviations of the sensors, where known.
    pub noise: Noise,
    /// Keys of the robot's table that the format does not define, in file order.
    pub notes: toml::Table,
    /// Commands to the actuators. A command holds until the next row.
    pub command: Option<Stream<Command>>,
    /// Wheel encoders.
    pub wheels: Option<Stream<Wheels>>,
    /// The robot's own estimate of its velocity.
    pub odometry: Option<Stream<Odometry>>,
    /// Ground truth from a camera or motion capture.
    pub pose: Option<Stream<Pose>>,
    /// Accelerometer and gyro.
    pub imu: Option<Stream<Imu>>,
    /// Motor currents and supply voltage.
    pub motor: Option<Stream<Motor>>,
}

/// The point of the robot whose pose is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PosePoint {
    /// The centre of mass c.
    CentreOfMass,
    /// The middle of the axle.
    Axle,
}

/// The quantity that the accelerometer columns hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImuKind {
    /// Specific force: the sensor's reading, with gravity.
    SpecificForce,
    /// Acceleration: gravity is already subtracted.
    Acceleration,
}

/// Noise of each sensor as one standard deviation, where known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Noise {
    /// Pose, x and y each (m).
    pub pose_m: Option<f64>,
    /// Pose, yaw (rad).
    pub pose_rad: Option<f64>,
    /// Accelerometer, each axis (m/s²).
    pub imu_m_s2: Option<f64>,
    /// Gyro (rad/s).
    pub imu_rad_s: Option<f64>,
    /// Wheel angle (rad).
    pub wheel_rad: Option<f64>,
    /// Odometry, forward speed (m/s).
    pub odometry_m_s: Option<f64>,
    /// Odometry, yaw rate (rad/s).
    pub odometry_rad_s: Option<f64>,
}

impl Robot {
    /// A robot without streams.
    pub fn named(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ..Self::default()
        }
    }

    /// Stamps (s) of each stream that tells how the robot moves: all but those of its motors.
    pub fn stamps(&self) -> impl Iterator<Item = &[f64]> {
        let all = [
            self.command.as_ref().map(|own| &own.t_s),
            self.wheels.as_ref().map(|own| &own.t_s),
            self.odometry.as_ref().map(|own| &own.t_s),
            self.pose.as_ref().map(|own| &own.t_s),
            self.imu.as_ref().map(|own| &own.t_s),
        ];
        all.into_iter().flatten().map(Vec::as_slice)
    }

    /// The last stamp of any of these (s).
    pub fn last_s(&self) -> Option<f64> {
        let lasts = self.stamps().filter_map(|own| own.last().copied());
        lasts.reduce(f64::max)
    }

    /// Encoder counts per turn of a wheel: those of the recording, else those of the model.
    pub fn counts_per_rev(&self, model: Option<&RobotModel>) -> Option<f64> {
        self.encoder_counts_per_rev
            .or_else(|| Some(model?.encoder.as_ref()?.counts_per_rev))
    }
}

/// Whether `name` can be the name of a robot, of its folder and of its topics: one path component
/// that is not hidden, of at most 128 bytes.
pub fn is_robot_name(name: &str) -> bool {
    !name.is_empty()
        && !name.starts_with('.')
        && name.len() <= 128
        && name
            .chars()
            .all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | ' '))
}
