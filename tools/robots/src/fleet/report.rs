//! What is known of a real robot at the end of a run.

use serde::{Deserialize, Serialize};

use crate::lab::Content;

/// What was heard of a robot, and what it was told.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RobotReport {
    /// Messages about its wheels.
    pub wheels: Stream,
    /// Poses; without messages where nobody tracks it.
    pub poses: Stream,
    /// Its own odometry beside its wheels.
    #[serde(default)]
    pub odometry: Stream,
    /// Its inertial sensor.
    #[serde(default)]
    pub imu: Stream,
    /// Commands that were sent to it.
    pub commands: u64,
    /// Commands that its limits have cut.
    pub cut: u64,
    /// How often it was told to stand because it was not heard or its agent was silent.
    pub stops: u64,
    /// Jumps of its wheel angles that no wheel can turn.
    pub jumps: u64,
    /// The first message that could not be read, in words.
    pub problem: Option<String>,
    /// Its last pose: x (m), y (m), yaw (rad) of c.
    pub last_pose: Option<[f64; 3]>,
}

impl RobotReport {
    /// What was heard of a content.
    pub fn stream(&self, content: Content) -> &Stream {
        match content {
            Content::Wheels => &self.wheels,
            Content::Pose => &self.poses,
            Content::Odometry => &self.odometry,
            Content::Imu => &self.imu,
        }
    }

    /// The same, to be written.
    pub(super) fn stream_mut(&mut self, content: Content) -> &mut Stream {
        match content {
            Content::Wheels => &mut self.wheels,
            Content::Pose => &mut self.poses,
            Content::Odometry => &mut self.odometry,
            Content::Imu => &mut self.imu,
        }
    }
}

/// A stream of messages.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Stream {
    /// Number of messages.
    pub messages: u64,
    /// Messages that could not be read.
    pub unreadable: u64,
    /// Longest time between two of them (s).
    pub longest_gap_s: f64,
    /// How much later than the fastest message the slowest one came (s).
    pub latest_s: f64,
}
