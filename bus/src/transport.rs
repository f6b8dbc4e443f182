//! Transport interface: the traits through which plant and agents exchange messages.
//!
//! Implemented over shared memory (`slipstream-ipc`) and in one process (`slipstream-launch`). An
//! agent communicates through [`PositionLink`], the plant through [`LockstepLink`].

use crate::message::{Encoders, Position, TorqueCommand};

/// A robot's side of its two links: from its predecessor and to its successor.
pub trait PositionLink {
    /// Returns the next position from the predecessor, in the order of sending, or `None` if none
    /// is waiting. Never blocks.
    ///
    /// # Errors
    /// The transport failed.
    fn poll(&mut self) -> Result<Option<Position>, BusError>;

    /// Sends a position to the successor and sets its `sent_ns`. Returns when the transport had it
    /// ready for the receiver (ns).
    ///
    /// # Errors
    /// The transport failed, or the receiver's queue is full.
    fn send(&mut self, position: &mut Position) -> Result<i64, BusError>;

    /// The time of the run that [`Self::send`] would stamp now (ns).
    fn now_ns(&self) -> i64;
}

/// The plant's side of the lockstep: a barrier with all agents at every instant a loop is due.
pub trait LockstepLink {
    /// Runs one round: wakes every agent at `now_ns` with its encoders, waits for all answers and
    /// stores them in `commands` in robot order.
    ///
    /// # Errors
    /// An agent does not answer, or the run is stopped.
    fn round(
        &mut self,
        now_ns: i64,
        encoders: &[Encoders],
        commands: &mut [TorqueCommand],
    ) -> Result<(), BusError>;

    /// Publishes the encoders at the end of the run without a round, so that the agents' odometry
    /// covers the last steps.
    ///
    /// # Errors
    /// The transport failed.
    fn publish_final(&mut self, now_ns: i64, encoders: &[Encoders]) -> Result<(), BusError>;
}

/// Why an operation of the transport failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BusError {
    /// The run was asked to stop.
    #[error("the run was stopped")]
    Stopped,
    /// An agent did not answer.
    #[error("{robot} does not answer")]
    NoAnswer {
        /// The robot.
        robot: String,
    },
    /// A receiver's queue is full, which cannot happen while all processes keep to the lockstep.
    #[error("{what}: the receiver's queue is full")]
    QueueFull {
        /// The service.
        what: String,
    },
    /// The shared memory or a library below it failed.
    #[error("{what}: {reason}")]
    Failed {
        /// The service or the operation.
        what: String,
        /// The error of the library.
        reason: String,
    },
}

impl BusError {
    /// A failure of the operation or service `what`, with the library's error.
    pub fn failed(what: impl Into<String>, reason: impl std::fmt::Debug) -> Self {
        Self::Failed {
            what: what.into(),
            reason: format!("{reason:?}"),
        }
    }
}
