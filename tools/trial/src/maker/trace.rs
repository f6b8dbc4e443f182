//! What really happened to one robot.

use super::sensors::{Looks, Sensors, between};
use crate::plant::{State, Strange};

/// Wheels that slide faster than this slip, for labels (m/s).
const SLIPS_M_S: f64 = 3e-3;
/// Intervals that are no further apart than this are one (s).
const PAUSE_S: f64 = 0.03;
/// A state is kept this often (s).
pub(crate) const KEEP_S: f64 = 5.0;

/// The truth about one robot.
#[derive(Debug, Clone)]
pub(crate) struct Trace {
    /// What was told, as the recording holds it.
    pub(crate) told: Vec<[f64; 2]>,
    pub(crate) sensors: Sensors,
    pub(crate) looks: Looks,
    /// States at the streams' looks.
    pub(crate) seen: [Vec<State>; 3],
    /// States every 5 s.
    pub(crate) kept: Vec<State>,
    /// Where c was at every command, and at the end.
    pub(crate) poses: Vec<[f64; 3]>,
    /// When wheels slipped (s).
    pub(crate) slips: Vec<[f64; 2]>,
    /// When a wheel was in a patch (s).
    pub(crate) patches: Vec<[f64; 2]>,
    /// When what the vocabulary does not hold was at work, where it is not always (s).
    pub(crate) strange: Vec<[f64; 2]>,
}

impl Trace {
    pub(crate) fn new(sensors: Sensors, looks: Looks) -> Self {
        Self {
            told: Vec::new(),
            sensors,
            looks,
            seen: [Vec::new(), Vec::new(), Vec::new()],
            kept: Vec::new(),
            poses: Vec::new(),
            slips: Vec::new(),
            patches: Vec::new(),
            strange: Vec::new(),
        }
    }

    /// Takes note of one step.
    pub(crate) fn note(&mut self, strange: &[Strange], before: &State, after: &State) {
        for (times, seen) in self.looks.0.iter().zip(&mut self.seen) {
            while let Some(&t_s) = times.get(seen.len()) {
                if t_s > after.t_s {
                    break;
                }
                seen.push(between(before, after, t_s.max(before.t_s)));
            }
        }
        let span = [before.t_s, after.t_s];
        if after.slip_m_s.iter().any(|slip| *slip > SLIPS_M_S) {
            extend(&mut self.slips, span);
        }
        if after.in_patch() {
            extend(&mut self.patches, span);
        }
        if strange
            .iter()
            .any(|strange| strange.at_work(after) == Some(true))
        {
            extend(&mut self.strange, span);
        }
    }
}

fn extend(intervals: &mut Vec<[f64; 2]>, [from, to]: [f64; 2]) {
    match intervals.last_mut() {
        Some(last) if from - last[1] <= PAUSE_S => last[1] = to,
        _ => intervals.push([from, to]),
    }
}
