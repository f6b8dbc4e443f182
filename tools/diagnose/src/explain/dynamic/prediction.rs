//! Predictions over windows of 5 s, before and after, and where their error went.

use rayon::prelude::*;

use super::channels::NO_CHANNEL;
use super::fit::{Fit, valued, values};
use super::machine::Machine;
use crate::answer::{Budget, HeldOut};
use crate::explain::budget::budget;
use crate::model::hypothesis::Hypothesis;
use crate::predict::misfit::Misfit;
use crate::predict::predictor::Predictor;
use crate::predict::window::Window;

/// Parts of the windows that are predicted by what was fitted to the others.
const FOLDS: usize = 2;
/// Iterations of such a fit.
const ITERATIONS: usize = 3;
/// Windows of a budget at most, and effects.
const BUDGET_WINDOWS: usize = 12;
const PLAYERS: usize = 5;

/// Predictions before and after; each window is predicted by effects that were fitted without it.
pub(crate) fn held_out(machine: &Machine, predictor: &Predictor, fit: &Fit) -> HeldOut {
    let windows = &predictor.windows;
    let before = predictor.misfit(windows, &[]);
    let after = if fit.hypotheses.is_empty() {
        before
    } else {
        let folds = (0..FOLDS).into_par_iter().map(|fold| {
            let own: Vec<Window> = windows.iter().skip(fold).step_by(FOLDS).cloned().collect();
            let learnt = machine
                .fitted_outside(fit, &own)
                .unwrap_or_else(|| fit.hypotheses.clone());
            predictor.misfit(&own, &learnt)
        });
        let folds: Vec<Misfit> = folds.collect();
        folds
            .iter()
            .fold(Misfit::default(), |sum, own| sum.and(own))
    };
    let mut held_out = HeldOut::default();
    held_out.add(predictor, &before, &after);
    held_out
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

/// Where the error of predictions went, in metres and radians.
pub(crate) fn budgets(machine: &Machine, predictor: &Predictor, fit: &Fit) -> Vec<Budget> {
    if fit.hypotheses.is_empty() {
        return Vec::new();
    }
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
        predictor.misfit(&windows, &own)
    });
    let worth: Vec<Misfit> = subsets.collect();
    let deviation = |channel: usize| predictor.deviation(channel);
    let mean = |misfit: &Misfit, channels: &[usize]| -> f64 {
        let each = channels
            .iter()
            .map(|c| misfit.mean_square(*c) * deviation(*c).powi(2));
        each.sum()
    };
    let has = |channel: usize| worth.first().is_some_and(|w| w.has(channel));
    let of = |unit: &'static str, channels: &[usize]| {
        if !channels.iter().all(|c| has(*c)) {
            return None;
        }
        let worth: Vec<f64> = worth.iter().map(|w| mean(w, channels)).collect();
        let noise: f64 = channels.iter().map(|c| deviation(*c).powi(2)).sum();
        budget(&machine.tracks[0].robot, unit, &names, &worth, noise)
    };
    [("m", &[2, 3][..]), ("rad", &[4][..])]
        .into_iter()
        .filter_map(|(unit, channels)| of(unit, channels))
        .collect()
}
