//! A likelihood of some blocks alone: to predict the others.

use nalgebra::{DMatrix, DVector};

use super::{BlockScore, Likelihood};

/// The likelihood without some blocks.
pub(crate) struct Masked<'a> {
    pub(crate) inner: &'a dyn Likelihood,
    /// Whether each block is left out.
    pub(crate) left_out: &'a [bool],
}

impl Masked<'_> {
    fn keeps(&self, block: usize) -> bool {
        !self.left_out.get(block).copied().unwrap_or(false)
    }
}

impl Likelihood for Masked<'_> {
    fn blocks(&self) -> usize {
        self.inner.blocks()
    }

    fn run_of(&self) -> Vec<usize> {
        self.inner.run_of()
    }

    fn clusters(&self) -> Option<&[usize]> {
        self.inner.clusters()
    }

    fn is_shared(&self, parameter: usize) -> bool {
        self.inner.is_shared(parameter)
    }

    fn value(&self, at: &[f64]) -> Vec<f64> {
        let mut all = self.inner.value(at);
        for (block, value) in all.iter_mut().enumerate() {
            if !self.keeps(block) {
                *value = 0.0;
            }
        }
        all
    }

    fn score(&self, at: &[f64], free: &[usize]) -> Vec<BlockScore> {
        let mut all = self.inner.score(at, free);
        let n = free.len();
        for (block, score) in all.iter_mut().enumerate() {
            if !self.keeps(block) {
                score.gradient = DVector::zeros(n);
                score.information = DMatrix::zeros(n, n);
            }
        }
        all
    }
}
