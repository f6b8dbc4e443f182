//! The true motion of one robot, and what its sensors sampled.

use super::sensors::{SampleTimes, Sensors, interpolate};
use slipstream_trial_plant::{OutsideEffect, State};

/// Slip speed from which on a label says that a wheel slips (m/s).
const SLIP_M_S: f64 = 3e-3;
/// Intervals with a gap of at most this are joined (s).
const MAX_GAP_S: f64 = 0.03;
/// Length of the windows for which predictions are compared (s).
pub(crate) const WINDOW_S: f64 = 5.0;

/// The truth about one robot.
#[derive(Debug, Clone)]
pub(crate) struct Truth {
    /// Commands as recorded.
    pub(crate) commands: Vec<[f64; 2]>,
    pub(crate) sensors: Sensors,
    pub(crate) sample_times: SampleTimes,
    /// States at the sample times of each stream.
    pub(crate) sampled: [Vec<State>; 3],
    /// State at the start of each window, and the final one if it ends a window.
    pub(crate) window_starts: Vec<State>,
    /// Pose of the centre of mass at every command and at the end.
    pub(crate) poses: Vec<[f64; 3]>,
    /// When wheels slipped (s).
    pub(crate) slips: Vec<[f64; 2]>,
    /// When a wheel was in a friction patch (s).
    pub(crate) patches: Vec<[f64; 2]>,
    /// When the effect outside the vocabulary acted, if it does not always (s).
    pub(crate) outside: Vec<[f64; 2]>,
}

impl Truth {
    pub(crate) fn new(sensors: Sensors, sample_times: SampleTimes) -> Self {
        Self {
            commands: Vec::new(),
            sensors,
            sample_times,
            sampled: [Vec::new(), Vec::new(), Vec::new()],
            window_starts: Vec::new(),
            poses: Vec::new(),
            slips: Vec::new(),
            patches: Vec::new(),
            outside: Vec::new(),
        }
    }

    /// Adds one step: the states before and after it.
    pub(crate) fn add_step(&mut self, outside: &[OutsideEffect], before: &State, after: &State) {
        for (times, sampled) in self.sample_times.0.iter().zip(&mut self.sampled) {
            while let Some(&t_s) = times.get(sampled.len()) {
                if t_s > after.t_s {
                    break;
                }
                sampled.push(interpolate(before, after, t_s.max(before.t_s)));
            }
        }
        let span = [before.t_s, after.t_s];
        if after.slip_m_s.iter().any(|slip| *slip > SLIP_M_S) {
            extend(&mut self.slips, span);
        }
        if after.in_patch() {
            extend(&mut self.patches, span);
        }
        if outside
            .iter()
            .any(|outside| outside.acts(after) == Some(true))
        {
            extend(&mut self.outside, span);
        }
    }
}

/// Appends an interval, or joins it to the last one.
fn extend(intervals: &mut Vec<[f64; 2]>, [from, to]: [f64; 2]) {
    match intervals.last_mut() {
        Some(last) if from - last[1] <= MAX_GAP_S => last[1] = to,
        _ => intervals.push([from, to]),
    }
}
