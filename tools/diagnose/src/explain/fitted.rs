//! What was fitted to the streams of one machine, as its predictions need it.

use super::search::Searched;
use crate::model::drive::{AVERAGED, DRIVE};
use crate::model::from_wheels::{DRIVE_FIRST, RUN_BIAS};
use crate::model::streams::{Streams, read};

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
        self.streams.drive?;
        let all = read(&self.found.nominal, &self.found.table.weights, at);
        Some(all[self.streams.drive_first()..].to_vec())
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
        let indices: Vec<usize> = biases.chain(mean).collect();
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
