//! One robot of a recording: its streams, and what is known about its sensors.

use super::streams::{Command, Imu, Motor, Odometry, Pose, Stream, Wheels};

/// What one robot recorded, and what is known about its sensors.
#[derive(Debug, Clone, Default)]
pub struct Robot {
    /// Its name: a plain folder name.
    pub name: String,
    /// Counts in one turn of the wheel, where wheels are ticks. Wins over the model's.
    pub encoder_counts_per_rev: Option<u32>,
    /// The point that the pose is of, where declared. Undeclared means the centre of mass.
    pub pose_point: Option<PosePoint>,
    /// What the accelerometer's numbers are, where declared. Undeclared means specific force.
    pub imu_kind: Option<ImuKind>,
    /// Standard deviations of the sensors, where known.
    pub noise: Noise,
    /// Keys that the format does not know, in their order.
    pub notes: toml::Table,
    /// What the actuators were told. A command holds until the next row.
    pub command: Option<Stream<Command>>,
    /// Wheel encoders.
    pub wheels: Option<Stream<Wheels>>,
    /// The robot's own velocity estimate.
    pub odometry: Option<Stream<Odometry>>,
    /// Ground truth from a camera or motion capture.
    pub pose: Option<Stream<Pose>>,
    /// Accelerometer and gyro.
    pub imu: Option<Stream<Imu>>,
    /// Motor currents and supply.
    pub motor: Option<Stream<Motor>>,
}

/// The point of the robot that its pose is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PosePoint {
    /// The centre of mass c.
    CentreOfMass,
    /// The middle of the axle.
    Axle,
}

/// What an accelerometer's numbers are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImuKind {
    /// As the sensor feels it, gravity included.
    SpecificForce,
    /// Gravity already taken away.
    Acceleration,
}

/// One standard deviation of each sensor's noise, where known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Noise {
    /// Of each of the pose's x and y (m).
    pub pose_m: Option<f64>,
    /// Of the pose's yaw (rad).
    pub pose_rad: Option<f64>,
    /// Of each acceleration (m/s²).
    pub imu_m_s2: Option<f64>,
    /// Of the yaw rate (rad/s).
    pub imu_rad_s: Option<f64>,
    /// Of a wheel's angle (rad).
    pub wheel_rad: Option<f64>,
    /// Of the odometry's speed (m/s).
    pub odometry_m_s: Option<f64>,
    /// Of the odometry's yaw rate (rad/s).
    pub odometry_rad_s: Option<f64>,
}

impl Robot {
    /// A robot that recorded nothing yet.
    pub fn named(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ..Self::default()
        }
    }
}

/// Whether `name` can name a robot's folder and its topics: one path component, nothing hidden.
pub fn is_robot_name(name: &str) -> bool {
    !name.is_empty()
        && !name.starts_with('.')
        && name.len() <= 128
        && name
            .chars()
            .all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | ' '))
}
