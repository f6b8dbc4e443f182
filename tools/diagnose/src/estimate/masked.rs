//! A likelihood of some blocks alone: to predict the others.

use nalgebra::{DMatrix, DVector};

use super::{BlockScore, Likelihood};

/// The likelihood of every block for which `keeps` is true.
pub(crate) struct Masked<'a> {
    pub(crate) inner: &'a dyn Likelihood,
    pub(crate) keeps: fn(usize) -> bool,
}

impl Likelihood for Masked<'_> {
    fn blocks(&self) -> usize {
        self.inner.blocks()
    }

    fn run_of(&self) -> Vec<usize> {
        self.inner.run_of()
    }

    fn is_shared(&self, parameter: usize) -> bool {
        self.inner.is_shared(parameter)
    }

    fn value(&self, at: &[f64]) -> Vec<f64> {
        let mut all = self.inner.value(at);
        for (block, value) in all.iter_mut().enumerate() {
            if !(self.keeps)(block) {
                *value = 0.0;
            }
        }
        all
    }

    fn score(&self, at: &[f64], free: &[usize]) -> Vec<BlockScore> {
        let mut all = self.inner.score(at, free);
        let n = free.len();
        for (block, score) in all.iter_mut().enumerate() {
            if !(self.keeps)(block) {
                score.gradient = DVector::zeros(n);
                score.information = DMatrix::zeros(n, n);
            }
        }
        all
    }
}
