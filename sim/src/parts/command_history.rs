//! Pure delay: past commands, kept until the delayed command has replaced them.

use std::collections::VecDeque;

use super::scalar::{Pair, Scalar};
use super::tolerances::SIMULTANEOUS_S;

/// Number of commands that are stored without allocation.
const CAPACITY: usize = 1024;

/// Past commands at the wheels, each with the time from which it was given (s), oldest first. Empty
/// without a delay.
#[derive(Debug, Clone)]
pub(crate) struct CommandHistory<S>(VecDeque<(f64, Pair<S>)>);

impl<S: Scalar> CommandHistory<S> {
    /// Reserves storage only if commands are delayed.
    pub(crate) fn new(delayed: bool) -> Self {
        Self(VecDeque::with_capacity(if delayed { CAPACITY } else { 0 }))
    }

    /// Forgets all commands but one, given since ever.
    pub(crate) fn reset(&mut self, command: Pair<S>) {
        self.0.clear();
        self.0.push_back((f64::NEG_INFINITY, command));
    }

    /// Stores the command given from `t_s` on and drops those that no longer act.
    pub(crate) fn store(&mut self, delay_s: S, t_s: f64, command: Pair<S>) {
        while self
            .0
            .get(1)
            .is_some_and(|(next_s, _)| next_s + delay_s.value() < t_s)
        {
            self.0.pop_front();
        }
        if self.0.back().is_none_or(|(_, last)| *last != command) {
            self.0.push_back((t_s, command));
        }
    }

    /// The command of `delay_s` ago, averaged over `span` = [start (s), length (s)], each command
    /// first mapped by `map`. No command changes in the span's interior (see
    /// [`CommandHistory::next_change`]). One that changes at its very end has no weight, but its
    /// derivative with respect to the delay has.
    pub(crate) fn delayed(
        &self,
        delay_s: S,
        span: Pair<f64>,
        map: impl Fn(Pair<S>) -> Pair<S>,
    ) -> Pair<S> {
        let [t_s, over_s] = span;
        let mut acting = [S::constant(0.0); 2];
        for &(since_s, command) in &self.0 {
            let acts_s = delay_s + since_s;
            let next = map(command);
            if acts_s.value() <= t_s + SIMULTANEOUS_S {
                acting = next;
            } else if acts_s.value() <= t_s + over_s + SIMULTANEOUS_S {
                let share = (-acts_s + t_s + over_s) / over_s;
                acting = [0, 1].map(|i| acting[i] + (next[i] - acting[i]) * share);
            }
        }
        acting
    }

    /// The first instant (s) in the interior of `span` at which a delayed command begins to act.
    pub(crate) fn next_change(&self, delay_s: S, span: Pair<f64>) -> Option<f64> {
        let delay_s = delay_s.value();
        let [from, to] = [span[0] + SIMULTANEOUS_S, span[0] + span[1] - SIMULTANEOUS_S];
        self.0
            .iter()
            .map(|(since_s, _)| since_s + delay_s)
            .find(|at| (from..to).contains(at))
    }
}
