//! In-memory form of a recording: robots with their streams, the messages between robots, and notes.
//!
//! Values are stored exactly as the file gives them: nothing is resampled, unwrapped or filtered,
//! and every stream keeps its own times. **NaN marks an empty cell** in a column of numbers (the
//! sensor did not measure that component). The readers reject a NaN written in a CSV file, so NaN
//! has no other meaning. A column that a stream does not have is `None`.
//!
//! Units are SI, angles are in radians; x points forward, y to the left, yaw is counter-clockwise.

mod angles;
mod links;
mod names;
mod robot;
mod streams;

use slipstream_bus::RobotModel;

pub(crate) use angles::{Unwrap, unwrap_angles};
pub use links::{LinkMessage, Links, RoundTrips};
pub(crate) use names::NamePool;
pub use robot::{ImuKind, Noise, PosePoint, Robot, is_robot_name};
pub use streams::{Command, Imu, Motor, Odometry, Pose, Stream, UnknownColumn, Wheels};

/// One recording: its robots, the messages between them, and its description.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// Name of the recording.
    pub name: String,
    /// Who or what made it.
    pub origin: String,
    /// What it was read from.
    pub read_from: ReadFrom,
    /// Whether the robots are runs of one and the same machine.
    pub same_robot: bool,
    /// Keys of `recording.toml` that the format does not define, in file order.
    pub notes: toml::Table,
    /// The robots, in the order of `recording.toml`.
    pub robots: Vec<Robot>,
    /// Position messages between robots.
    pub links: Option<Links>,
    /// Measured round trips of a network.
    pub rtt: Option<RoundTrips>,
    /// The nominal robot model that came with the recording.
    pub model: Option<RobotModel>,
}

/// What a recording was read from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ReadFrom {
    /// Memory, or a file of slipstream's own.
    #[default]
    Own,
    /// A folder with `recording.toml`.
    Folder,
    /// A bag of another robot, with a map of its topics.
    Bag,
    /// CSV files of other programs, with a map of their columns.
    Columns,
}

impl Recording {
    /// The robot with this name, if there is one.
    pub fn robot(&self, name: &str) -> Option<&Robot> {
        self.robots.iter().find(|robot| robot.name == name)
    }

    /// Whether its origin is a robot that runs ROS, such as a bag.
    pub fn is_of_ros(&self) -> bool {
        let mut words = self.origin.split(|c: char| !c.is_alphanumeric());
        let known = ["ros", "ros1", "ros2", "rosbag", "rosbag2"];
        words.any(|word| known.iter().any(|own| word.eq_ignore_ascii_case(own)))
    }
}
