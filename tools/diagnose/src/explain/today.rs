//! What changed, found beside runs from before, as a fit of the runs of today alone: what both share is as
//! the model has it, and changes are added to it.

use nalgebra::DMatrix;

use super::calibration::{Calibration, Joint};
use super::drive::DriveFit;
use crate::estimate::cluster::Precision;
use crate::estimate::scoring::{Fit, Problem};
use crate::model::command_to_wheels::{CommandToWheels, NOISE};
use crate::model::drive::DRIVE;
use crate::model::from_wheels::{FromWheels, MACHINE, RUN_SCALE, RUN_TRACK, View};
use crate::select::elimination::{Kept, Selected, Term};

/// From a fit of all runs to one of today's.
struct Projection<'a> {
    /// Index of a parameter among those of today.
    index: &'a dyn Fn(usize) -> Option<usize>,
    /// Whether a parameter is a change.
    is_change: &'a dyn Fn(usize) -> bool,
    problem: &'a Problem<'a>,
    nominal: &'a [f64],
}

impl Projection<'_> {
    fn selected(&self, found: &Selected) -> Selected {
        let fit = &found.fit;
        let mut at = self.nominal.to_vec();
        for (from, value) in fit.at.iter().enumerate() {
            if let Some(to) = (self.index)(from) {
                let base = if (self.is_change)(from) {
                    self.nominal[to]
                } else {
                    0.0
                };
                at[to] = base + value;
            }
        }
        let places = fit.free.iter().enumerate();
        let left: Vec<(usize, usize)> = places
            .filter_map(|(place, from)| Some((place, (self.index)(*from)?)))
            .collect();
        let free: Vec<usize> = left.iter().map(|(_, to)| *to).collect();
        let of_left = |all: &DMatrix<f64>| {
            DMatrix::from_fn(left.len(), left.len(), |i, k| all[(left[i].0, left[k].0)])
        };
        let kept = found.kept.iter().map(|kept| Kept {
            term: Term {
                parameters: kept
                    .term
                    .parameters
                    .iter()
                    .filter_map(|index| (self.index)(*index))
                    .collect(),
                ..kept.term.clone()
            },
            ..kept.clone()
        });
        Selected {
            fit: Fit {
                objective: self.problem.objective(&at, &free),
                at,
                free,
                converged: fit.converged,
            },
            precision: Precision {
                covariance: of_left(&found.precision.covariance),
                expected: of_left(&found.precision.expected),
                overdispersion: found.precision.overdispersion,
            },
            kept: kept.collect(),
            alike: found.alike.clone(),
            halves: found.halves.as_ref().map(|own| own.of(&left)),
        }
    }
}

/// A calibration of all runs about `joint_nominal`, as one of today's.
pub(super) fn calibration(
    found: Calibration,
    joint: &FromWheels,
    joint_nominal: Vec<f64>,
    nominal: &[f64],
) -> Calibration {
    let is_dense = found.dense.is_some();
    let all = found.dense.unwrap_or_else(|| joint.clone());
    let machine = all.today();
    let before = joint.before.runs;
    let width = machine.of_run(1, 0) - machine.of_run(0, 0);
    let shared = joint.shared(0);
    let index = |from: usize| match from {
        own if own < MACHINE => Some(own),
        own if own >= shared => None,
        own => own
            .checked_sub(before * width)
            .filter(|own| *own >= MACHINE),
    };
    let paired = (before..all.runs.len()).filter(|run| all.as_before(*run).is_some());
    let of_runs: Vec<usize> = paired
        .flat_map(|run| [RUN_SCALE, RUN_TRACK].map(|own| all.of_run(run, own)))
        .collect();
    let view = View {
        machine: &machine,
        robust: true,
    };
    let after = Projection {
        index: &index,
        is_change: &|from| from < MACHINE || of_runs.contains(&from),
        problem: &machine.problem(&view, nominal),
        nominal,
    }
    .selected(&found.after);
    Calibration {
        after,
        dense: is_dense.then_some(machine),
        joint: Some(Joint {
            machine: all,
            nominal: joint_nominal,
            after: found.after,
        }),
        ..found
    }
}

/// A drive fitted to all runs, as one of today's.
pub(super) fn drive(found: DriveFit, today: &CommandToWheels, nominal: Vec<f64>) -> DriveFit {
    let index = |from: usize| (from < DRIVE + NOISE).then_some(from);
    let after = Projection {
        index: &index,
        is_change: &|from| from < DRIVE,
        problem: &today.problem(today, &nominal),
        nominal: &nominal,
    }
    .selected(&found.after);
    DriveFit {
        after,
        nominal,
        criterion: found.criterion,
        band_rad_s: found.band_rad_s,
        joint: Some(Box::new(found)),
    }
}
