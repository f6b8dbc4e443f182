//! Predictions over windows of 5 s, before and after, and where their error went.

use rayon::prelude::*;

use super::channels::NO_CHANNEL;
use super::fit::{Fit, valued, values};
use super::machine::Machine;
use crate::answer::{Budget, HeldOut};
use crate::data::track::Sensor;
use crate::filter::dynamic::open_loop::{Sums, add_variances};
use crate::judge::{self, HEADING, Judged, PLACE, POSE, Score, Squares, culprits};
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

/// What every window scores, without and with what was found.
pub(crate) struct Predicted<'a> {
    machine: &'a Machine,
    predictor: &'a Predictor,
    fit: &'a Fit,
    windows: [Vec<Score>; 2],
    sums: [Score; 2],
}

impl<'a> Predicted<'a> {
    /// Predicts every window by the nominal model, and by effects that were fitted without it.
    pub(crate) fn new(machine: &'a Machine, predictor: &'a Predictor, fit: &'a Fit) -> Self {
        let windows = &predictor.windows;
        let before = predictor.scores(windows, &[]);
        let mut after = if fit.hypotheses.is_empty() {
            before.clone()
        } else {
            unseen(machine, predictor, fit)
        };
        let expected = expected(machine, fit);
        for score in &mut after {
            expected
                .iter()
                .for_each(|(quantity, mean)| score.expect(*quantity, *mean));
        }
        Self {
            machine,
            predictor,
            fit,
            sums: [Score::of_all(&before), Score::of_all(&after)],
            windows: [before, after],
        }
    }

    /// The effect by which predictions become worse than those of the nominal model; `None` where they do not.
    pub(crate) fn culprit(&self) -> Option<(&'static str, &'static str)> {
        let [before, after] = &self.windows;
        let quantity = judge::worse(before, after).into_iter().max()?;
        let (names, worth) = self.worth();
        let squares: Option<Vec<f64>> = worth.iter().map(|own| own.mean_square(quantity)).collect();
        let (player, _) = *culprits(names.len(), &squares?).first()?;
        Some((names.get(player).copied()?, judge::NAMES[quantity]))
    }

    pub(crate) fn held_out(&self) -> HeldOut {
        let track = &self.machine.tracks[0];
        let angles = track.of(Sensor::WheelAngle).is_some();
        let [before, after] = &self.sums;
        judge::held_out(&track.robot, WINDOW_S, [before, after], &|channel| {
            unit(channel, angles)
        })
    }

    /// What the judge is told of the machine.
    pub(crate) fn judged(&self, refused: Vec<String>) -> Judged {
        let windows = self.predictor.windows.iter().zip(&self.windows[1]);
        Judged {
            robot: self.machine.tracks[0].robot.clone(),
            before: self.sums[0],
            after: self.sums[1],
            windows: windows
                .map(|(window, score)| ([window.from_s, window.to_s], *score))
                .collect(),
            refused,
        }
    }

    /// Where the error of predictions went, in metres and radians.
    pub(crate) fn budgets(&self) -> Vec<Budget> {
        let (names, worth) = self.worth();
        let [before, after] = &self.sums;
        let of = |(unit, quantity): (&'static str, usize)| {
            let worth: Option<Vec<f64>> =
                worth.iter().map(|own| own.mean_square(quantity)).collect();
            let squares = Squares {
                robot: &self.machine.tracks[0].robot,
                unit,
                held_out: [before.mean_square(quantity)?, after.mean_square(quantity)?],
                sensor: after.sensor(quantity)?,
                expected: after.expected(quantity)?,
            };
            judge::budget(&squares, &names, &worth?)
        };
        [("m", PLACE), ("rad", HEADING)]
            .into_iter()
            .filter_map(of)
            .collect()
    }

    /// Effects, and what every subset of them (as bits) scores on some windows.
    fn worth(&self) -> (Vec<&'static str>, Vec<Score>) {
        let windows = self.predictor.some_windows(BUDGET_WINDOWS);
        let mut names: Vec<&'static str> = self.fit.hypotheses.iter().map(|h| h.info.id).collect();
        names.sort_unstable();
        names.dedup();
        names.truncate(PLAYERS);
        let subsets = (0..1_usize << names.len()).into_par_iter().map(|subset| {
            let has = |h: &&Hypothesis| match names.iter().position(|n| *n == h.info.id) {
                Some(place) => subset >> place & 1 == 1,
                None => true,
            };
            let own: Vec<Hypothesis> = self.fit.hypotheses.iter().filter(has).cloned().collect();
            Score::of_all(&self.predictor.scores(&windows, &own))
        });
        let worth = subsets.collect();
        (names, worth)
    }
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
