//! What was selected: the terms that are needed, their fit, and how well a combination of parameters is known.

use nalgebra::DMatrix;

use super::halves::Halves;
use crate::estimate::cluster::Precision;
use crate::estimate::scoring::Fit;
use crate::estimate::term::Term;

/// A term that is needed, and why.
#[derive(Debug, Clone)]
pub(crate) struct Kept {
    pub(crate) term: Term,
    /// Log-likelihood that it brings (nats).
    pub(crate) gain: f64,
    /// Its Wald statistic.
    pub(crate) wald: f64,
    /// Variance of each of its parameters below which nobody would call it a difference.
    pub(crate) floors: Vec<f64>,
}

/// The outcome of an elimination.
#[derive(Debug, Clone)]
pub(crate) struct Selected {
    pub(crate) fit: Fit,
    pub(crate) precision: Precision,
    pub(crate) kept: Vec<Kept>,
    /// Terms that were kept, each with one that fits as well in its place.
    pub(crate) alike: Vec<[&'static str; 2]>,
    /// What the halves of the recordings say by themselves, where each of them can.
    pub(crate) halves: Option<Halves>,
}

impl Selected {
    /// Nothing, of so many parameters that are 0.
    pub(crate) fn nothing(parameters: usize) -> Self {
        Self {
            fit: Fit {
                at: vec![0.0; parameters],
                free: Vec::new(),
                objective: 0.0,
                converged: true,
            },
            precision: Precision {
                covariance: DMatrix::zeros(0, 0),
                expected: DMatrix::zeros(0, 0),
                dispersion: Vec::new(),
            },
            kept: Vec::new(),
            alike: Vec::new(),
            halves: None,
        }
    }

    /// A term that was kept.
    pub(crate) fn kept(&self, name: &str) -> Option<&Kept> {
        self.kept.iter().find(|kept| kept.term.name == name)
    }

    /// Deviation of a linear combination of free parameters, given as (index, weight).
    pub(crate) fn deviation(&self, weights: &[(usize, f64)]) -> f64 {
        let used = self.placed(weights);
        let mut variance = 0.0;
        for (a, wa) in &used {
            for (b, wb) in &used {
                variance += wa * wb * self.precision.covariance[(*a, *b)];
            }
        }
        for (index, weight) in weights {
            variance += weight * weight * self.floor(*index);
        }
        (variance.max(0.0) + self.spread(weights)).sqrt()
    }

    /// Variance of a linear combination of free parameters that its halves differ by beyond their own errors: what
    /// is not constant is known no better than it varies.
    fn spread(&self, weights: &[(usize, f64)]) -> f64 {
        let Some([difference, error]) = self.difference(weights) else {
            return 0.0;
        };
        let excess = difference * difference - error * error;
        // the mean of two halves
        if excess > 0.0 { excess / 4.0 } else { 0.0 }
    }

    /// By how much the second half's value of a linear combination is larger than the first one's, and the
    /// deviation of that difference; `None` where they do not differ beyond it.
    pub(crate) fn difference(&self, weights: &[(usize, f64)]) -> Option<[f64; 2]> {
        let halves = self.halves.as_ref()?;
        let floors: f64 = weights
            .iter()
            .map(|(index, weight)| 2.0 * weight * weight * self.floor(*index))
            .sum();
        halves.difference(&self.placed(weights), floors)
    }

    /// A linear combination by places among the free parameters.
    fn placed(&self, weights: &[(usize, f64)]) -> Vec<(usize, f64)> {
        let all = weights.iter();
        all.filter_map(|(index, weight)| Some((self.fit.place(*index)?, *weight)))
            .collect()
    }

    fn floor(&self, index: usize) -> f64 {
        let mut floors = self
            .kept
            .iter()
            .flat_map(|k| k.term.parameters.iter().zip(&k.floors));
        floors
            .find(|(own, _)| **own == index)
            .map_or(0.0, |(_, floor)| *floor)
    }
}
