//! What a robot's topics tell.

use super::robot::LabRobot;

/// What a topic tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// What the wheels do.
    Wheels,
    /// Where the robot is.
    Pose,
    /// The robot's own odometry, beside its wheels.
    Odometry,
    /// What its inertial sensor measures.
    Imu,
}

/// Number of contents.
pub(crate) const CONTENTS: usize = Content::ALL.len();

impl Content {
    /// All, in the order of their topics.
    pub const ALL: [Self; 4] = [Self::Wheels, Self::Pose, Self::Odometry, Self::Imu];

    /// What a robot has topics for, in the order of [`Self::ALL`].
    pub fn of(robot: &LabRobot) -> impl Iterator<Item = Self> {
        let all = Self::ALL.into_iter();
        all.filter(|content| content.topic(robot).is_some())
    }

    /// What it is called: `wheels`, `pose`, `odometry` or `imu`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wheels => "wheels",
            Self::Pose => "pose",
            Self::Odometry => "odometry",
            Self::Imu => "imu",
        }
    }

    /// The name of a robot's topic that tells it, if it has one.
    pub fn topic(self, robot: &LabRobot) -> Option<&str> {
        match self {
            Self::Wheels => Some(robot.wheels.topic()),
            Self::Pose => robot.pose.as_ref().map(|pose| pose.topic.as_str()),
            Self::Odometry => robot.odometry.as_deref(),
            Self::Imu => robot.imu.as_deref(),
        }
    }
}
