//! The one in-memory form of every recording: streams that keep their own times.
//!
//! Numbers are what the file says, bit for bit; nothing is resampled, unwrapped or filtered. In a
//! column of numbers **NaN stands for an empty cell** (the sensor did not see that component); a
//! NaN in a file is an error, so the two never mix. A column that a stream does not have is `None`.
//! SI units, radians; x forward, y left, yaw counter-clockwise.

use std::sync::Arc;

use slipstream_bus::RobotModel;

/// One recording: robots, the messages between them, and what is known about it all.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// What it is called.
    pub name: String,
    /// Who or what made it.
    pub origin: String,
    /// The robots are runs of one machine.
    pub same_robot: bool,
    /// Keys of `recording.toml` that the format does not know, in their order.
    pub notes: toml::Table,
    /// The robots, in the order of `recording.toml`.
    pub robots: Vec<Robot>,
    /// Position messages between robots.
    pub links: Option<Links>,
    /// A network's measured round trips.
    pub rtt: Option<RoundTrips>,
    /// The nominal model that came with the recording.
    pub model: Option<RobotModel>,
}

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

/// Rows over time: one time and one value of every column each.
#[derive(Debug, Clone, Default)]
pub struct Stream<V> {
    /// The time of each row (s), never decreasing, always finite.
    pub t_s: Vec<f64>,
    /// The columns, each as long as `t_s`.
    pub values: V,
    /// Columns that the format does not know, kept as text.
    pub unknown: Vec<UnknownColumn>,
}

/// A column that the format does not know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownColumn {
    /// Its head.
    pub name: String,
    /// Its cells, one a row.
    pub cells: Vec<String>,
}

/// What the actuators were told.
#[derive(Debug, Clone)]
pub enum Command {
    /// Torque at each wheel (N m).
    Torque {
        /// Right wheel (N m).
        right_nm: Vec<f64>,
        /// Left wheel (N m).
        left_nm: Vec<f64>,
    },
    /// Voltage at each motor (V).
    Voltage {
        /// Right motor (V).
        right_v: Vec<f64>,
        /// Left motor (V).
        left_v: Vec<f64>,
    },
    /// Speed of each wheel (rad/s).
    WheelSpeed {
        /// Right wheel (rad/s).
        right_rad_s: Vec<f64>,
        /// Left wheel (rad/s).
        left_rad_s: Vec<f64>,
    },
    /// Forward speed and yaw rate of the robot.
    Twist {
        /// Forward speed (m/s).
        v_m_s: Vec<f64>,
        /// Yaw rate (rad/s).
        w_rad_s: Vec<f64>,
    },
}

/// What the wheel encoders said.
#[derive(Debug, Clone)]
pub enum Wheels {
    /// Signed cumulative counts; an empty cell is `None`.
    Ticks {
        /// Right wheel (counts).
        right: Vec<Option<i64>>,
        /// Left wheel (counts).
        left: Vec<Option<i64>>,
    },
    /// Angles from an unknown start (rad).
    Angle {
        /// Right wheel (rad).
        right_rad: Vec<f64>,
        /// Left wheel (rad).
        left_rad: Vec<f64>,
    },
    /// Speeds (rad/s).
    Speed {
        /// Right wheel (rad/s).
        right_rad_s: Vec<f64>,
        /// Left wheel (rad/s).
        left_rad_s: Vec<f64>,
    },
}

/// The robot's own velocity estimate.
#[derive(Debug, Clone, Default)]
pub struct Odometry {
    /// Forward speed (m/s).
    pub v_m_s: Vec<f64>,
    /// Yaw rate (rad/s), where there is one.
    pub w_rad_s: Option<Vec<f64>>,
}

/// Ground truth of the declared point.
#[derive(Debug, Clone, Default)]
pub struct Pose {
    /// World x (m).
    pub x_m: Vec<f64>,
    /// World y (m).
    pub y_m: Vec<f64>,
    /// Heading (rad), wrapped or not as the file has it; `None` where the sensor sees none.
    pub yaw_rad: Option<Vec<f64>>,
}

/// Body-frame inertial measurements at the centre of mass; at least one axis is there.
#[derive(Debug, Clone, Default)]
pub struct Imu {
    /// Forward (m/s²).
    pub ax_m_s2: Option<Vec<f64>>,
    /// To the left (m/s²).
    pub ay_m_s2: Option<Vec<f64>>,
    /// Yaw rate (rad/s).
    pub gz_rad_s: Option<Vec<f64>>,
}

/// Electrical measurements of the motors; at least one column is there.
#[derive(Debug, Clone, Default)]
pub struct Motor {
    /// Right motor (A).
    pub current_right_a: Option<Vec<f64>>,
    /// Left motor (A).
    pub current_left_a: Option<Vec<f64>>,
    /// Supply (V).
    pub supply_v: Option<Vec<f64>>,
}

/// Position messages from robot to robot, in the order in which they were sent.
#[derive(Debug, Clone, Default)]
pub struct Links {
    /// The messages.
    pub messages: Vec<LinkMessage>,
    /// Whether the velocities were sent along (the columns are there).
    pub with_velocity: bool,
    /// Columns that the format does not know, kept as text.
    pub unknown: Vec<UnknownColumn>,
}

/// One position message.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkMessage {
    /// When it was sent (s).
    pub t_sent_s: f64,
    /// When it arrived (s); `None`: it was lost.
    pub t_received_s: Option<f64>,
    /// The sender.
    pub from: Arc<str>,
    /// The receiver.
    pub to: Arc<str>,
    /// Sent x (m); NaN where empty, as in all that follow.
    pub x_m: f64,
    /// Sent y (m).
    pub y_m: f64,
    /// Sent heading (rad).
    pub yaw_rad: f64,
    /// Sent forward speed (m/s).
    pub v_m_s: f64,
    /// Sent yaw rate (rad/s).
    pub w_rad_s: f64,
}

/// Measured round trips of a network, in the order of measurement.
#[derive(Debug, Clone, Default)]
pub struct RoundTrips {
    /// The sequence number of each.
    pub seq: Vec<i64>,
    /// Its round trip (ms); NaN where empty.
    pub rtt_ms: Vec<f64>,
    /// Columns that the format does not know, kept as text.
    pub unknown: Vec<UnknownColumn>,
}

impl Recording {
    /// The robot of that name.
    pub fn robot(&self, name: &str) -> Option<&Robot> {
        self.robots.iter().find(|robot| robot.name == name)
    }
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

impl<V> Stream<V> {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
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
