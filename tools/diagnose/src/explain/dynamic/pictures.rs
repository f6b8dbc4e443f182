//! What the figures of a report show of a machine with masses.

use super::fit::Fit;
use super::limits::limits;
use super::machine::Machine;
use super::selection::Selected;
use crate::answer::{Figures, MissingForce, Paths, Point, Residuals};
use crate::data::track::{CHANNEL_NAMES, CHANNELS, Sensor};
use crate::model::hypothesis::Hypothesis;
use crate::predict::predictor::Predictor;
use crate::predict::window::{WINDOW_S, cut};

/// A gap between pieces of a line.
const GAP: Point = (f64::NAN, f64::NAN);

/// One run predicted window by window.
struct Predicted {
    /// Residuals of each channel (deviations).
    residuals: Vec<Vec<Point>>,
    seen: Vec<Point>,
    path: Vec<Point>,
}

/// The figures of one machine.
pub(crate) fn figures(
    machine: &Machine,
    predictor: &Predictor,
    selected: &Selected,
    all: &[Hypothesis],
) -> Figures {
    let (mut residuals, mut forces, mut paths) = (Vec::new(), Vec::new(), Vec::new());
    let found = !selected.fit.hypotheses.is_empty();
    for run in 0..machine.runs.len() {
        let before = of_run(predictor, run, &[]);
        let after = found.then(|| of_run(predictor, run, &selected.fit.hypotheses));
        for (channel, name) in CHANNEL_NAMES.iter().enumerate().take(CHANNELS) {
            let own = &before.residuals[channel];
            if own.iter().any(|(_, r)| r.is_finite()) {
                residuals.push(Residuals {
                    run,
                    channel: name,
                    before: own.clone(),
                    after: after
                        .as_ref()
                        .map_or_else(Vec::new, |after| after.residuals[channel].clone()),
                });
            }
        }
        if before.seen.iter().any(|(x, _)| x.is_finite()) {
            paths.push(Paths {
                run,
                camera: before.seen,
                before: before.path,
                after: after.map_or_else(Vec::new, |after| after.path),
            });
        }
        let before = missing(machine, &selected.nominal, run);
        let after = missing(machine, &selected.fit, run);
        let parts = [
            "missing force along the body (N)",
            "missing moment about the vertical (N m)",
        ];
        for ((quantity, before), after) in parts.into_iter().zip(before).zip(after) {
            forces.push(MissingForce {
                run,
                quantity: quantity.to_owned(),
                before,
                after: if found { after } else { Vec::new() },
            });
        }
    }
    Figures {
        robot: machine.tracks[0].robot.clone(),
        spans_s: machine.tracks.iter().map(|track| track.span_s()).collect(),
        residuals,
        forces,
        against: Vec::new(),
        paths,
        limits: limits(machine, &selected.fit, all),
    }
}

/// The disturbances along and about that the filter estimates over time (N, N m).
fn missing(machine: &Machine, fit: &Fit, run: usize) -> [Vec<Point>; 2] {
    let mut lines = [Vec::new(), Vec::new()];
    machine.watched(fit, &fit.hypotheses, |own, t_s, _, disturbance| {
        if own == run {
            lines[0].push((t_s, disturbance[0]));
            lines[1].push((t_s, disturbance[1]));
        }
    });
    lines
}

fn of_run(predictor: &Predictor, run: usize, hypotheses: &[Hypothesis]) -> Predicted {
    let simulated = predictor.simulated(hypotheses);
    let track = &predictor.tracks[run];
    let mut out = Predicted {
        residuals: vec![Vec::new(); CHANNELS],
        seen: Vec::new(),
        path: Vec::new(),
    };
    let pose = track.series.iter().position(|s| s.sensor == Sensor::Pose);
    for window in cut(track, run, WINDOW_S) {
        let predicted = simulated
            .as_ref()
            .and_then(|simulated| predictor.predicted(simulated, &window));
        let Some((residuals, _)) = predicted else {
            continue;
        };
        let rows = window.channels.iter().zip(&window.stamps_s).zip(&residuals);
        for ((channel, stamp_s), residual) in rows {
            if let Some(own) = out.residuals.get_mut(usize::from(*channel)) {
                own.push((*stamp_s, *residual));
            }
        }
        out.residuals.iter_mut().for_each(|line| line.push(GAP));
        let Some(which) = pose else { continue };
        let deviation = track.series[which].deviation;
        for (_, pose, base) in window.measured(track, which) {
            let residual = |i: usize| residuals.get(base + i).copied().unwrap_or(f64::NAN);
            out.seen.push((pose[0], pose[1]));
            let at = |i: usize| pose[i] + residual(i) * deviation[i];
            out.path.push((at(0), at(1)));
        }
        out.seen.push(GAP);
        out.path.push(GAP);
    }
    out
}
