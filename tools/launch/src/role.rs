//! Roles of the processes of a run.

use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_ipc::wake_page::Member;

/// What a process of a run does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// The physics of all robots.
    Plant,
    /// The controller of one robot.
    Agent(RobotIndex),
    /// The writer of the recording.
    Recorder,
}

impl Role {
    /// The first argument of a process in this role.
    pub(crate) fn argument(self) -> &'static str {
        match self {
            Self::Plant => "plant",
            Self::Agent(_) => "agent",
            Self::Recorder => "recorder",
        }
    }

    /// The process on the wake-up page.
    pub(crate) fn member(self) -> Member {
        match self {
            Self::Plant => Member::Plant,
            Self::Agent(robot) => Member::Agent(robot as usize),
            Self::Recorder => Member::Recorder,
        }
    }

    /// An agent's robot.
    pub(crate) fn robot(self) -> Option<RobotIndex> {
        match self {
            Self::Agent(robot) => Some(robot),
            Self::Plant | Self::Recorder => None,
        }
    }

    /// Name of the process: `plant`, `recorder`, or the robot's name.
    pub(crate) fn name(self) -> String {
        self.robot()
            .map_or_else(|| self.argument().to_owned(), robot_name)
    }
}
