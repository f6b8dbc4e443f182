//! Outcome of a trial step: the mode holds, or an event ends it.

use crate::parts::friction_elements::ElementSet;
use crate::parts::scalar::{Scalar, Vector};

/// What became of the set of held elements in a step.
#[derive(Debug, Clone, Copy)]
pub(crate) enum StepOutcome<S> {
    /// It holds from start to end.
    Steady,
    /// These elements do not hold at the start.
    Broken(ElementSet),
    /// It ceases to hold inside the step.
    Event(Event<S>),
    /// It may hold, but the step is too long to say, until it is halved so often.
    Coarse(u32),
}

/// What happens inside a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Event<S> {
    /// What is above zero before and below zero after it, at the step's start and end.
    pub(crate) margins: [S; 2],
    /// ElementSet that come to rest.
    pub(crate) stopped: ElementSet,
    /// ElementSet that break away.
    pub(crate) broken: ElementSet,
    /// Acceleration until then.
    pub(crate) before: Vector<S>,
}

impl<S: Scalar> Event<S> {
    pub(crate) fn new(before: S, after: S) -> Self {
        let none = ElementSet::default();
        Self {
            margins: [before, after],
            stopped: none,
            broken: none,
            before: Vector::zeros(),
        }
    }

    /// How much later the event is where a parameter moves it (s): zero, with derivatives. The
    /// forces before it act that much longer and those after it shorter.
    pub(crate) fn shift(&self, over_s: f64) -> S {
        let [before, after] = self.margins;
        let rate = (after.value() - before.value()) / over_s;
        if rate == 0.0 {
            return S::constant(0.0);
        }
        (after - S::constant(after.value())) / -rate
    }
}
