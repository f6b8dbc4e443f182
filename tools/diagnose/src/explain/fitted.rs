//! What was fitted to the streams of one machine, as its predictions need it.

use super::search::Searched;
use crate::model::command_to_wheels::TIMES;
use crate::model::drive::{AVERAGED, DRIVE, LAG, PULL};
use crate::model::streams::{Streams, read};
use crate::model::wheel_parameters::{DRIVE_FIRST, RUN_BIAS};

/// Sine of the steepest slope that is said.
const MOST_SINE: f64 = 0.99;

/// What was fitted to a machine.
#[derive(Clone, Copy)]
pub(crate) struct Fitted<'a> {
    pub(crate) streams: Streams<'a>,
    pub(crate) found: &'a Searched,
}

impl Fitted<'_> {
    /// Parameters of the machine and its drive at `at`.
    pub(crate) fn machine_at(&self, at: &[f64]) -> Vec<f64> {
        let all = read(&self.found.nominal, &self.found.table.weights, at);
        let middle = self.streams.drive_first();
        let mut own = all[..middle].to_vec();
        if self.streams.drive.is_some() {
            own[DRIVE_FIRST..DRIVE_FIRST + DRIVE].copy_from_slice(&all[middle..middle + DRIVE]);
        }
        own
    }

    /// The same with noise sizes of the drive, behind its parameters.
    pub(crate) fn drive_at(&self, at: &[f64]) -> Option<Vec<f64>> {
        let drive = self.streams.drive?;
        let all = read(&self.found.nominal, &self.found.table.weights, at);
        let mut own = all[self.streams.drive_first()..].to_vec();
        let times_s = drive.runs[0].times_s(&own);
        for (place, time_s) in TIMES.into_iter().zip(times_s) {
            own[DRIVE + place] = time_s.ln();
        }
        Some(own)
    }

    /// Share of the body that the motors move, of what the model says: of robots with masses that are told voltages.
    pub(crate) fn share(&self) -> Option<f64> {
        let load = self.streams.reference.volts?.load?;
        let at = &self.found.selected.fit.at;
        let own = |at: &[f64]| self.machine_at(at)[DRIVE_FIRST + LAG].abs();
        let listed_s = own(&vec![0.0; at.len()]) - load.lag_s();
        Some(load.share(own(at) - listed_s))
    }

    /// Grades along a robot, nominal and fitted: downhill ahead is positive.
    pub(crate) fn grades(&self) -> Option<[f64; 2]> {
        let per_sine = self.streams.reference.volts?.load?.speed_per_sine;
        let at = &self.found.selected.fit.at;
        let grade = |at: &[f64]| {
            let sine = self.machine_at(at)[DRIVE_FIRST + PULL] / per_sine;
            sine.clamp(-MOST_SINE, MOST_SINE).asin().tan()
        };
        Some([grade(&vec![0.0; at.len()]), grade(at)])
    }

    /// Of `at`, what belongs to sensors of single runs, or is a convention of a log, and is no effect.
    pub(crate) fn nuisances(&self, at: &[f64]) -> Vec<f64> {
        let reference = self.streams.reference;
        let runs = 0..reference.runs.len();
        let biases = runs.map(|run| reference.of_run(run, RUN_BIAS));
        let mean = self
            .streams
            .drive
            .map(|_| self.streams.drive_first() + AVERAGED);
        let is_loaded = reference.volts.is_some_and(|own| own.load.is_some());
        let load = is_loaded.then(|| self.streams.of_drive(LAG));
        let indices: Vec<usize> = biases.chain(mean).chain(load).collect();
        let keeps =
            |weights: &Vec<(usize, f64)>| weights.iter().all(|(index, _)| indices.contains(index));
        let pairs = self.found.table.weights.iter().zip(at);
        pairs
            .map(|(weights, own)| if keeps(weights) { *own } else { 0.0 })
            .collect()
    }

    /// The nuisances of `at`, and of the rest these parameters alone.
    pub(crate) fn with<'b>(&self, at: &[f64], kept: impl Iterator<Item = &'b usize>) -> Vec<f64> {
        let mut own = self.nuisances(at);
        for index in kept {
            own[*index] = at[*index];
        }
        own
    }
}
