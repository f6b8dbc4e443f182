//! A bank of onsets: for each instant since which something may have changed, the score and the information of all
//! parameters that may (generalised likelihood ratio; Willsky and Jones 1976; Basseville and Nikiforov 1993, section 7).
//!
//! A change at an onset moves the state of a filter from then on and not before, so that each onset has derivatives of
//! its own of each filter's state, which are zero at the onset. Recent onsets are dense, older ones sparse: memory
//! and work do not grow with time.

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector};

use super::linear::Linear;
use super::statistic::Sum;

/// Time between recent onsets (s), and between older ones as a share of their age.
pub(crate) const ONSET_STEP_S: f64 = 0.5;
const AGE_SHARE: f64 = 1.0 / 8.0;
/// Age of the oldest onset but the first (s).
const OLDEST_S: f64 = 256.0;

/// An instant since which something may have changed.
#[derive(Debug, Clone)]
pub(crate) struct Onset {
    pub(crate) t_s: f64,
    /// Of each filter, the derivatives of its state by its parameters.
    states: Vec<Vec<f64>>,
    /// Derivatives of the log-likelihood since then, and their expected covariance.
    pub(crate) sum: Sum,
    /// What the first onset had when this one was opened.
    pub(crate) before: Sum,
}

/// A filter of the bank: how long its state is, and which of all parameters each of its own is.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    pub(crate) n: usize,
    pub(crate) places: Vec<usize>,
}

/// The bank.
#[derive(Debug, Clone)]
pub(crate) struct Bank {
    pub(crate) parameters: usize,
    sources: Vec<Source>,
    /// By age, the oldest first.
    pub(crate) onsets: VecDeque<Onset>,
    scratch: Vec<f64>,
}

impl Bank {
    pub(crate) fn new(parameters: usize, sources: Vec<Source>) -> Self {
        Self {
            parameters,
            sources,
            onsets: VecDeque::new(),
            scratch: Vec::new(),
        }
    }

    /// From now on (s) something may have changed.
    pub(crate) fn open(&mut self, t_s: f64) {
        let states = self.sources.iter();
        let none = Sum {
            score: DVector::zeros(self.parameters),
            information: DMatrix::zeros(self.parameters, self.parameters),
        };
        let first = self.onsets.front().map(|own| own.sum.clone());
        self.onsets.push_back(Onset {
            t_s,
            states: states
                .map(|own| vec![0.0; own.n * own.places.len()])
                .collect(),
            before: first.unwrap_or_else(|| none.clone()),
            sum: none,
        });
        self.thin(t_s);
    }

    /// Leaves out onsets that are denser than their age asks for; the first stays.
    fn thin(&mut self, now_s: f64) {
        let mut at = 1;
        while at + 1 < self.onsets.len() {
            let gap_s = self.onsets[at + 1].t_s - self.onsets[at - 1].t_s;
            let age_s = now_s - self.onsets[at].t_s;
            if age_s > OLDEST_S || gap_s <= AGE_SHARE * age_s + 1e-9 {
                self.onsets.remove(at);
            } else {
                at += 1;
            }
        }
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.onsets.clear();
    }

    /// The state of a filter begins anew: what changed before moves it no more.
    pub(crate) fn lose(&mut self, source: usize) {
        for onset in &mut self.onsets {
            onset.states[source].fill(0.0);
        }
    }

    /// A row of a filter, with the weight of its log-likelihood.
    pub(crate) fn hear(&mut self, source: usize, row: &Linear, weight: f64) {
        let places = &self.sources[source].places;
        for onset in &mut self.onsets {
            onset.hear(source, places, row, weight, &mut self.scratch);
        }
    }
}

impl Onset {
    fn hear(
        &mut self,
        source: usize,
        places: &[usize],
        row: &Linear,
        weight: f64,
        scratch: &mut Vec<f64>,
    ) {
        let Linear { m, n, p, .. } = *row;
        let state = &mut self.states[source];
        scratch.clear();
        scratch.extend_from_slice(&row.by_parameters);
        add_product(scratch, &row.by_state, state, [m, n, p]);
        for i in 0..m {
            let slopes = &scratch[i * p..(i + 1) * p];
            let e = row.innovation[i];
            for (a, place) in slopes.iter().zip(places).filter(|(a, _)| **a != 0.0) {
                self.sum.score[*place] -= weight * a * e;
                for (b, other) in slopes.iter().zip(places) {
                    self.sum.information[(*place, *other)] += weight * a * b;
                }
            }
        }
        scratch.clear();
        scratch.extend_from_slice(&row.state_by_parameters);
        add_product(scratch, &row.state_by_state, state, [n, n, p]);
        state.copy_from_slice(scratch);
    }
}

/// Adds the product of an m by n and an n by p matrix.
fn add_product(out: &mut [f64], a: &[f64], b: &[f64], [m, n, p]: [usize; 3]) {
    for i in 0..m {
        let out = &mut out[i * p..(i + 1) * p];
        for k in 0..n {
            let factor = a[i * n + k];
            if factor != 0.0 {
                for (own, b) in out.iter_mut().zip(&b[k * p..(k + 1) * p]) {
                    *own += factor * b;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A random walk x, measured with an offset that may change: e = z - x - offset, x' = x + gain e.
    fn row(e: f64, gain: f64) -> Linear {
        Linear {
            m: 1,
            n: 1,
            p: 1,
            innovation: vec![e],
            by_state: vec![-1.0],
            by_parameters: vec![-1.0],
            state_by_state: vec![1.0 - gain],
            state_by_parameters: vec![-gain],
        }
    }

    fn bank() -> Bank {
        Bank::new(
            1,
            vec![Source {
                n: 1,
                places: vec![0],
            }],
        )
    }

    #[test]
    fn a_step_is_found_where_it_happened_and_as_large_as_it_was() {
        let (gain, size) = (0.3, 2.0);
        let mut bank = bank();
        let mut x = 0.0;
        for k in 0..40 {
            let t_s = f64::from(k) * ONSET_STEP_S;
            bank.open(t_s);
            let z = if k >= 30 { size } else { 0.0 };
            let e = z - x;
            x += gain * e;
            bank.hear(0, &row(e, gain), 1.0);
        }
        let gain_of = |own: &Onset| own.sum.score[0].powi(2) / own.sum.information[(0, 0)];
        let best = bank
            .onsets
            .iter()
            .max_by(|a, b| gain_of(a).total_cmp(&gain_of(b)));
        let best = best.unwrap();
        assert_eq!(best.t_s, 15.0);
        assert!((best.sum.score[0] / best.sum.information[(0, 0)] - size).abs() < 1e-9);
    }

    #[test]
    fn onsets_stay_few_and_recent_ones_dense() {
        let mut bank = bank();
        let mut most = 0;
        for k in 0..20_000 {
            bank.open(f64::from(k) * ONSET_STEP_S);
            most = most.max(bank.onsets.len());
        }
        assert!(most < 80, "{most}");
        let recent: Vec<f64> = bank
            .onsets
            .iter()
            .rev()
            .take(8)
            .map(|own| own.t_s)
            .collect();
        assert!(
            recent
                .windows(2)
                .all(|pair| pair[0] - pair[1] == ONSET_STEP_S)
        );
        assert_eq!(bank.onsets[0].t_s, 0.0);
        let old = bank.onsets[1].t_s;
        assert!(bank.onsets.back().unwrap().t_s - old <= OLDEST_S + ONSET_STEP_S);
    }
}
