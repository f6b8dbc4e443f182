//! What each half of the recordings says of a fit: a constant is the same in both.

use nalgebra::DMatrix;

use crate::estimate::cluster::Precision;
use crate::estimate::masked::Masked;
use crate::estimate::scoring::{Fit, Problem, SHORT};

/// Halves differ where their difference is larger than this many of its deviations: one in 250 does by chance.
const DIFFER: f64 = 2.9;
/// Blocks that a half needs.
const LEAST_BLOCKS: usize = 4;

/// Differences of the free parameters between the halves.
#[derive(Debug, Clone)]
pub(crate) struct Halves {
    /// Second half minus first, in the order of the free parameters.
    pub(crate) differences: Vec<f64>,
    /// Covariance of the differences of those that are physics.
    pub(crate) covariance: DMatrix<f64>,
}

impl Halves {
    /// Fits the halves by themselves, given as the blocks that each leaves out, from `fit`, of which the first
    /// `physics` free parameters are physics. `None` where a half does not determine them.
    pub(crate) fn new(
        problem: &Problem<'_>,
        fit: &Fit,
        physics: usize,
        left_out: &[Vec<bool>; 2],
    ) -> Option<Self> {
        let counts = [0, 1].map(|half| left_out[half].iter().filter(|out| **out).count());
        if counts.iter().any(|count| *count < LEAST_BLOCKS) {
            return None;
        }
        let half = |left_out: &[bool]| {
            let masked = Masked {
                inner: problem.likelihood,
                left_out,
            };
            let own = Problem {
                likelihood: &masked,
                priors: problem.priors.clone(),
                longest: problem.longest.clone(),
                sizes: problem.sizes.clone(),
            };
            let fit = own.fit(&fit.at, &fit.free, SHORT);
            let precision = Precision::new(&own, &fit, physics)?;
            Some((fit, precision.covariance))
        };
        let (early, a) = half(&left_out[0])?;
        let (late, b) = half(&left_out[1])?;
        let differences = fit
            .free
            .iter()
            .map(|index| late.at[*index] - early.at[*index]);
        Some(Self {
            differences: differences.collect(),
            covariance: a + b,
        })
    }

    /// Of some parameters alone, given as (place, new index) of those that are kept.
    pub(crate) fn of(&self, left: &[(usize, usize)]) -> Self {
        let physics = left
            .iter()
            .filter(|(place, _)| *place < self.covariance.nrows());
        let places: Vec<usize> = physics.map(|(place, _)| *place).collect();
        Self {
            differences: left
                .iter()
                .map(|(place, _)| self.differences[*place])
                .collect(),
            covariance: DMatrix::from_fn(places.len(), places.len(), |i, k| {
                self.covariance[(places[i], places[k])]
            }),
        }
    }

    /// Difference of a linear combination, given as (place among the free parameters, weight), and its deviation
    /// with `floors` added to its variance; `None` where it is within chance.
    pub(crate) fn difference(&self, weights: &[(usize, f64)], floors: f64) -> Option<[f64; 2]> {
        let size = self.covariance.nrows();
        if weights.is_empty() || weights.iter().any(|(place, _)| *place >= size) {
            return None;
        }
        let mut variance = floors;
        for (i, wi) in weights {
            for (k, wk) in weights {
                variance += wi * wk * self.covariance[(*i, *k)];
            }
        }
        let difference: f64 = weights.iter().map(|(i, w)| w * self.differences[*i]).sum();
        let differs = difference * difference > DIFFER * DIFFER * variance;
        (differs && variance > 0.0).then(|| [difference, variance.sqrt()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_beyond_chance_is_told_with_its_error() {
        let halves = Halves {
            differences: vec![0.3, 0.02],
            covariance: DMatrix::from_row_slice(2, 2, &[1e-4, 0.0, 0.0, 1e-4]),
        };
        assert_eq!(halves.difference(&[(1, 1.0)], 0.0), None);
        let [difference, error] = halves.difference(&[(0, 1.0)], 0.0).unwrap();
        assert!((difference - 0.3).abs() < 1e-12 && (error - 0.01).abs() < 1e-12);
        // nobody would call it a difference
        assert_eq!(halves.difference(&[(0, 1.0)], 0.1), None);
    }
}
