//! Score and information over all blocks.

use nalgebra::{DMatrix, DVector};

use crate::estimate::BlockScore;

/// Score and information over all blocks.
pub(super) struct Sums {
    pub(super) gradient: DVector<f64>,
    pub(super) information: DMatrix<f64>,
}

impl Sums {
    pub(super) fn new(scores: &[BlockScore]) -> Self {
        let count = scores.first().map_or(0, |own| own.gradient.len());
        let mut sums = Self {
            gradient: DVector::zeros(count),
            information: DMatrix::zeros(count, count),
        };
        for block in scores {
            sums.gradient += &block.gradient;
            sums.information += &block.information;
        }
        sums
    }
}
