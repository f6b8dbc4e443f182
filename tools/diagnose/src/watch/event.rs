//! What a watch says.

use super::alarm::State;
use crate::answer::{Finding, Warning};

/// A change of a robot.
#[derive(Debug, Clone)]
pub struct Change {
    /// When it was said, and since when it holds (s, as the recording counts).
    pub t_s: f64,
    /// See `t_s`.
    pub onset_s: f64,
    /// Whose.
    pub robot: String,
    /// What it is.
    pub finding: Finding,
    /// How sure that is.
    pub state: State,
}

/// What a watch says.
#[derive(Debug, Clone)]
pub enum Event {
    /// Something of a robot changed.
    Change(Box<Change>),
    /// Rows are not as they should be, at this time (s): no physics.
    Fault(f64, Warning),
}
