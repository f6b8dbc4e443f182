//! The one in-memory form of every recording: streams that keep their own times.
//!
//! Numbers are what the file says, bit for bit; nothing is resampled, unwrapped or filtered. In a
//! column of numbers **NaN stands for an empty cell** (the sensor did not see that component); a
//! NaN in a file is an error, so the two never mix. A column that a stream does not have is `None`.
//! SI units, radians; x forward, y left, yaw counter-clockwise.

mod angles;
mod links;
mod names;
mod robot;
mod streams;

use slipstream_bus::RobotModel;

pub(crate) use angles::unwrap;
pub use links::{LinkMessage, Links, RoundTrips};
pub(crate) use names::Names;
pub use robot::{ImuKind, Noise, PosePoint, Robot, is_robot_name};
pub use streams::{Command, Imu, Motor, Odometry, Pose, Stream, UnknownColumn, Wheels};

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

impl Recording {
    /// The robot of that name.
    pub fn robot(&self, name: &str) -> Option<&Robot> {
        self.robots.iter().find(|robot| robot.name == name)
    }
}
