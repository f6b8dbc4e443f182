//! Predictions over windows of 5 s, before and after, and where their error went.

use rayon::prelude::*;

use super::channels::NO_CHANNEL;
use super::fit::{Fit, valued, values};
use super::machine::Machine;
use crate::answer::HeldOut;
use crate::data::track::Sensor;
use crate::filter::dynamic::open_loop::{Sums, add_variances};
use crate::judge::{HEADING, PLACE, POSE, Predictions, Score, Worth};
use crate::model::hypothesis::Hypothesis;
use crate::predict::predictor::{FITTED_S, Predictor, unit};
use crate::predict::window::{WINDOW_S, Window};

/// Parts of the windows that are predicted by what was fitted to the others.
const FOLDS: usize = 2;
/// Iterations of such a fit.
const ITERATIONS: usize = 3;
/// Windows of a budget at most, and effects.
const BUDGET_WINDOWS: usize = 12;
const PLAYERS: usize = 5;

/// What every window scores by the nominal model, and by effects that were fitted without it.
pub(crate) fn predictions(machine: &Machine, predictor: &Predictor, fit: &Fit) -> Predictions {
    let windows = &predictor.windows;
    let before = predictor.scores(windows, &[]);
    let mut after = match (fit.hypotheses.is_empty(), windows.len()) {
        (true, _) => before.clone(),
        // beside a single window there is nothing to fit to
        (_, 1) => predictor.scores(windows, &fit.hypotheses),
        _ => unseen(machine, predictor, fit),
    };
    let expected = expected(machine, fit);
    for score in &mut after {
        for (quantity, mean) in &expected {
            score.expect(*quantity, *mean);
        }
    }
    let spans_s = windows.iter().map(|window| [window.from_s, window.to_s]);
    Predictions::new(&machine.tracks[0].robot, spans_s.collect(), [before, after])
}

/// The predictions of a machine as they are answered.
pub(crate) fn held_out(machine: &Machine, predictions: &Predictions) -> HeldOut {
    let angles = machine.tracks[0].of(Sensor::WheelAngle).is_some();
    predictions.held_out(WINDOW_S, &|channel| unit(channel, angles))
}

/// What every subset of the effects that were found is worth.
pub(crate) fn worth(predictor: &Predictor, fit: &Fit) -> Worth {
    let windows = predictor.some_windows(BUDGET_WINDOWS);
    let mut names: Vec<&'static str> = fit.hypotheses.iter().map(|h| h.info.id).collect();
    names.sort_unstable();
    names.dedup();
    names.truncate(PLAYERS);
    let subsets = (0..1_usize << names.len()).into_par_iter().map(|subset| {
        let has = |h: &&Hypothesis| match names.iter().position(|n| *n == h.info.id) {
            Some(place) => subset >> place & 1 == 1,
            None => true,
        };
        let own: Vec<Hypothesis> = fit.hypotheses.iter().filter(has).cloned().collect();
        predictor.scores(&windows, &own)
    });
    let scores: Vec<Vec<Score>> = subsets.collect();
    Worth::new(names, &scores)
}

/// What each window scores by effects that were fitted without it.
fn unseen(machine: &Machine, predictor: &Predictor, fit: &Fit) -> Vec<Score> {
    let windows = &predictor.windows;
    let folds = (0..FOLDS).into_par_iter().map(|fold| {
        let own: Vec<Window> = windows.iter().skip(fold).step_by(FOLDS).cloned().collect();
        let learnt = machine
            .fitted_outside(fit, &own)
            .unwrap_or_else(|| fit.hypotheses.clone());
        predictor.scores(&own, &learnt)
    });
    let folds: Vec<Vec<Score>> = folds.collect();
    (0..windows.len())
        .map(|window| folds[window % FOLDS][window / FOLDS])
        .collect()
}

/// Mean variance that process noise adds to each quantity over the windows.
fn expected(machine: &Machine, fit: &Fit) -> Vec<(usize, f64)> {
    let mut sums = Sums::default();
    for (run, pass) in machine.runs.iter().zip(&fit.passes) {
        add_variances(run, pass, &fit.noise, [WINDOW_S, FITTED_S], &mut sums);
    }
    let mean = |channel: usize| {
        let [sum, count] = sums[channel];
        (count > 0.0).then(|| sum / count)
    };
    let mut all: Vec<(usize, f64)> = (0..sums.len())
        .filter_map(|channel| Some((channel, mean(channel)?)))
        .collect();
    if let (Some(x), Some(y)) = (mean(POSE), mean(POSE + 1)) {
        all.push((PLACE, x + y));
    }
    all.extend(mean(POSE + 2).map(|yaw| (HEADING, yaw)));
    all
}

impl Machine {
    /// The effects of `fit` fitted without what was measured in `windows`, at its gains.
    fn fitted_outside(&self, fit: &Fit, windows: &[Window]) -> Option<Vec<Hypothesis>> {
        let inside = |stamp_s: f64, run: usize| {
            let mut own = windows.iter().filter(|w| w.run == run);
            own.any(|w| (w.from_s..w.to_s).contains(&stamp_s))
        };
        let channels: Vec<u8> = self
            .channels
            .iter()
            .zip(&self.stamps)
            .map(|(channel, (stamp_s, run))| {
                if inside(*stamp_s, *run) {
                    NO_CHANNEL
                } else {
                    *channel
                }
            })
            .collect();
        let at = values(&fit.hypotheses);
        let solution = self.solve_on(fit, &fit.hypotheses, &at, ITERATIONS, &channels)?;
        Some(valued(&fit.hypotheses, &solution.at))
    }
}
