//! Outcome of a trial step: accepted, ended by an event, or to be repeated.

use crate::parts::friction_constraints::ConstraintSet;
use crate::parts::scalar::{Scalar, Vector};

/// Whether the mode holds throughout a trial step.
#[derive(Debug, Clone, Copy)]
pub(crate) enum StepOutcome<S> {
    /// The mode holds from start to end.
    Accepted,
    /// These sticking constraints exceed their friction limit at the start already.
    LimitExceeded(ConstraintSet),
    /// The mode ends inside the step.
    Event(Event<S>),
    /// The step is too long to be accurate; it has to be bisected this many times.
    TooLong(u32),
}

/// The end of a mode: a margin that crosses zero inside a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Event<S> {
    /// The margin at the step's start and end: positive before the event, negative after it.
    /// The depth in a patch that a wheel enters rises instead.
    pub(crate) margins: [S; 2],
    /// Sliding constraints that come to rest.
    pub(crate) stopped: ConstraintSet,
    /// Sticking constraints that break away.
    pub(crate) broken_away: ConstraintSet,
    /// Acceleration before the event.
    pub(crate) before: Vector<S>,
}

impl<S: Scalar> Event<S> {
    /// An event whose margin is `start` at the step's start and `end` at its end.
    pub(crate) fn new(start: S, end: S) -> Self {
        let none = ConstraintSet::default();
        Self {
            margins: [start, end],
            stopped: none,
            broken_away: none,
            before: Vector::zeros(),
        }
    }

    /// Shift δt of the event's time (s) with the parameters that carry derivatives: its value is
    /// zero, its derivatives are those of the event time (implicit function theorem), for an event
    /// located in a step of `over_s`.
    pub(crate) fn time_shift(&self, over_s: f64) -> S {
        let [start, end] = self.margins;
        let rate = (end.value() - start.value()) / over_s;
        if rate == 0.0 {
            return S::constant(0.0);
        }
        (end - S::constant(end.value())) / -rate
    }
}
