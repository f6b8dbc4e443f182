//! Transport interface: the traits through which plant and agents exchange messages.
//!
//! Implemented over shared memory (`slipstream-ipc`) and in one process (`slipstream-launch`). An
//! agent communicates through [`PositionLink`], the plant through [`LockstepLink`].

use crate::message::{DriveCommand, Encoders, Position};

/// A robot's side of its links: from the robots that it hears and to those that hear it.
pub trait PositionLink {
    /// Returns the next position from a robot that this one hears, those of one sender in the order of
    /// sending, or `None` if none is waiting. Never blocks.
    ///
    /// # Errors
    /// The transport failed.
    fn poll(&mut self) -> Result<Option<Position>, BusError>;

    /// Sends a position to all robots that hear this one and sets its `sent_ns`. Returns when the transport had it
    /// ready for the receivers (ns).
    ///
    /// # Errors
    /// The transport failed, or a receiver's queue is full.
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
        commands: &mut [DriveCommand],
    ) -> Result<(), BusError>;

    /// Publishes the encoders at the end of the run without a round, so that the agents' odometry
    /// covers the last steps.
    ///
    /// # Errors
    /// The transport failed.
    fn publish_final(&mut self, now_ns: i64, encoders: &[Encoders]) -> Result<(), BusError>;
}

/// Why an operation of the transport failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
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
    /// The controller of a robot cannot go on.
    #[error("its {at} failed at {time_s:.3} s: {reason}")]
    Controller {
        /// What it did, such as "outer loop".
        at: &'static str,
        /// The time of the run (s).
        time_s: f64,
        /// Why.
        reason: String,
    },
    /// The controller of a robot panicked; the text says where.
    #[error("{0}")]
    Panicked(String),
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
