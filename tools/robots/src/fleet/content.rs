//! What a robot's topics tell.

use crate::lab::LabRobot;

/// What a topic tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// What the wheels do.
    Wheels,
    /// Where the robot is.
    Pose,
}

impl Content {
    /// The name of a robot's topic that tells it.
    pub fn topic(self, robot: &LabRobot) -> &str {
        match (self, &robot.pose) {
            (Self::Pose, Some(pose)) => &pose.topic,
            _ => robot.wheels.topic(),
        }
    }
}
