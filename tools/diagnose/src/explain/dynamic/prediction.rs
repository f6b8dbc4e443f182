//! Predictions over windows of 5 s, before and after, and where their error went.

use rayon::prelude::*;

use super::judged::Judged;
use crate::answer::HeldOut;
use crate::data::track::Sensor;
use crate::estimate::scoring::SearchLimits;
use crate::filter::dynamic::open_loop::{Sums, add_variances};
use crate::judge::{HEADING, PLACE, POSE, Predictions, Score, Worth};
use crate::model::hypothesis::Hypothesis;
use crate::model::plant::channels::NO_CHANNEL;
use crate::model::plant::filtered::Filtered;
use crate::model::plant::likelihood::Plant;
use crate::model::plant::machine::Machine;
use crate::predict::predictor::{FITTED_S, Predictor, unit};
use crate::predict::window::{WINDOW_S, Window};

/// Parts of the windows that are predicted by what was fitted to the others.
const FOLDS: usize = 2;
/// A fit of these.
const LEARNT: SearchLimits = SearchLimits {
    iterations: 3,
    tolerance_nats: 0.5,
};
/// Windows of a budget at most, and effects.
const BUDGET_WINDOWS: usize = 12;
const PLAYERS: usize = 5;

/// What every window scores by the nominal model, and by effects that were fitted without it.
pub(crate) fn predictions(judged: &Judged, predictor: &Predictor) -> Predictions {
    let (machine, fit) = (&judged.machine, &judged.selected.fit);
    let windows = &predictor.windows;
    let before = predictor.scores(windows, &[]);
    let mut after = match (fit.hypotheses.is_empty(), windows.len()) {
        (true, _) => before.clone(),
        // beside a single window there is nothing to fit to
        (_, 1) => predictor.scores(windows, &fit.hypotheses),
        _ => unseen(judged, predictor),
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
pub(crate) fn worth(predictor: &Predictor, fit: &Filtered) -> Worth {
    let windows = predictor.some_windows(BUDGET_WINDOWS);
    let mut names: Vec<&'static str> = fit.hypotheses.iter().map(|h| h.info.id).collect();
    names.sort_unstable();
    names.dedup();
    names.truncate(PLAYERS);
    Worth::new(names, |left_out| {
        let own = fit.hypotheses.iter();
        let own = own.filter(|own| !left_out.contains(&own.info.id));
        predictor.scores(&windows, &own.cloned().collect::<Vec<_>>())
    })
}

/// What each window scores by effects that were fitted without it.
fn unseen(judged: &Judged, predictor: &Predictor) -> Vec<Score> {
    let windows = &predictor.windows;
    let folds = (0..FOLDS).into_par_iter().map(|fold| {
        let own: Vec<Window> = windows.iter().skip(fold).step_by(FOLDS).cloned().collect();
        predictor.scores(&own, &fitted_outside(judged, &own))
    });
    let folds: Vec<Vec<Score>> = folds.collect();
    (0..windows.len())
        .map(|window| folds[window % FOLDS][window / FOLDS])
        .collect()
}

/// Mean variance that process noise adds to each quantity over the windows.
fn expected(machine: &Machine, fit: &Filtered) -> Vec<(usize, f64)> {
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

/// The effects that were selected, fitted without what was measured in `windows`, at their noise.
fn fitted_outside(judged: &Judged, windows: &[Window]) -> Vec<Hypothesis> {
    let mut machine = judged.machine.clone();
    let inside = |stamp_s: f64, run: usize| {
        let mut own = windows.iter().filter(|w| w.run == run);
        own.any(|w| (w.from_s..w.to_s).contains(&stamp_s))
    };
    for (channel, (stamp_s, run)) in machine.channels.iter_mut().zip(&judged.machine.stamps) {
        if inside(*stamp_s, *run) {
            *channel = NO_CHANNEL;
        }
    }
    let (table, at) = (&judged.table, &judged.selected.at);
    let plant = Plant::new(&machine, table);
    let fit = table
        .problem(&plant)
        .fit(at, &table.acting_parameters(at), LEARNT);
    table.hypotheses(&fit.at)
}
