//! How the cores meet the bus. Two homes: shared memory between processes, and one process.
//!
//! An agent's end is [`PositionLink`]; the plant's end is [`LockstepLink`]. A core sees nothing else of a run.

use crate::message::{Encoders, Position, TorqueCommand};

/// A robot's end of the links.
pub trait PositionLink {
    /// The next position from the robot ahead, in the order of sending.
    ///
    /// # Errors
    /// When the transport failed.
    fn receive(&mut self) -> Result<Option<Position>, BusError>;

    /// Hands a position to the bus. The transport stamps `sent_ns`, and returns when the bus had
    /// it ready for the receiver (ns).
    ///
    /// # Errors
    /// When the transport failed, or the receiver's queue is full.
    fn send(&mut self, position: &mut Position) -> Result<i64, BusError>;

    /// The run's time (ns), as sendings are stamped with it.
    fn now_ns(&self) -> i64;
}

/// The plant's end of the lockstep: one round of all agents.
pub trait LockstepLink {
    /// Wakes every agent at `now_ns` with its encoders and waits for all torques, in robot order.
    ///
    /// # Errors
    /// When an agent does not answer: it died, or the run is to stop.
    fn round(
        &mut self,
        now_ns: i64,
        encoders: &[Encoders],
        commands: &mut [TorqueCommand],
    ) -> Result<(), BusError>;

    /// Shows the agents the encoders at the end, so that their odometry ends where the run does.
    ///
    /// # Errors
    /// When the transport fails.
    fn end(&mut self, now_ns: i64, encoders: &[Encoders]) -> Result<(), BusError>;
}

/// Why the bus failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BusError {
    /// Somebody asked the run to stop.
    #[error("the run was stopped")]
    Stopped,
    /// An agent did not answer.
    #[error("{robot} does not answer")]
    Silent {
        /// The robot.
        robot: String,
    },
    /// A receiver's queue is full although lockstep never leaves so much in it.
    #[error("{what}: the receiver's queue is full")]
    Full {
        /// The service.
        what: String,
    },
    /// The shared memory or what lies beneath it failed.
    #[error("{what}: {reason}")]
    Failed {
        /// The service or the step.
        what: String,
        /// What the library said.
        reason: String,
    },
}

impl BusError {
    /// A failure of what lies beneath.
    pub fn failed(what: impl Into<String>, reason: impl std::fmt::Debug) -> Self {
        Self::Failed {
            what: what.into(),
            reason: format!("{reason:?}"),
        }
    }
}
