//! Roles of the processes of a run.

use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_ipc::wake_page::Member;

/// What a process of a run does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// The physics of all robots.
    Plant,
    /// In place of the plant: what stands before real robots.
    Robots,
    /// The controller of one robot.
    Agent(RobotIndex),
    /// The writer of the recording.
    Recorder,
    /// What stands for the agents on other hosts, the first of which is this robot's.
    StandIn(RobotIndex),
    /// On another host: what stands for the plant and the recorder.
    Relay,
}

impl Role {
    /// The first argument of a process in this role.
    pub(crate) fn argument(self) -> &'static str {
        match self {
            Self::Plant => "plant",
            Self::Robots => "robots",
            Self::Agent(_) => "agent",
            Self::Recorder => "recorder",
            Self::StandIn(_) => "hosts",
            Self::Relay => "relay",
        }
    }

    /// The process on the wake-up page.
    pub(crate) fn member(self) -> Member {
        match self {
            Self::Plant | Self::Robots | Self::Relay => Member::Plant,
            Self::Agent(robot) | Self::StandIn(robot) => Member::Agent(robot as usize),
            Self::Recorder => Member::Recorder,
        }
    }

    /// An agent's robot.
    pub(crate) fn robot(self) -> Option<RobotIndex> {
        match self {
            Self::Agent(robot) => Some(robot),
            Self::Plant | Self::Robots | Self::Recorder | Self::StandIn(_) | Self::Relay => None,
        }
    }

    /// Whether it leads the rounds of its host.
    pub(crate) fn leads(self) -> bool {
        matches!(self, Self::Plant | Self::Robots | Self::Relay)
    }

    /// Whether it ends after all others, because it keeps what they leave.
    pub(crate) fn ends_last(self) -> bool {
        matches!(self, Self::Recorder | Self::Relay)
    }

    /// Name of the process: `plant`, `robots`, `recorder`, `hosts`, `relay`, or the robot's name.
    pub(crate) fn name(self) -> String {
        self.robot()
            .map_or_else(|| self.argument().to_owned(), robot_name)
    }
}
