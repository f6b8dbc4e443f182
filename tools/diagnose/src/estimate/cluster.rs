//! Covariance by a delete-a-block jackknife (CV3; MacKinnon, Nielsen and Webb 2023): each
//! leave-one-out estimate by one Newton step.
//!
//! Neighbouring rows of a real recording err together. Blocks of some seconds do so much less, and
//! their spread is what an estimate is known by.

use nalgebra::{DMatrix, DVector};

use super::BlockScore;
use super::raised::raised;
use super::scoring::{Fit, Problem};

/// A leave-one-out step is limited to this many standard deviations of the model.
const CLIP: f64 = 4.0;
/// The same for logs of noise sizes.
const NOISE_CLIP: f64 = 2.0;
/// From this many runs on, what they share is also known by how they differ.
pub(crate) const LEAST_RUNS: usize = 3;
/// Least variance relative to the model's: fewer blocks than parameters would say less than nothing.
const LEAST_SHARE: f64 = 0.25;

/// The blocks with data that are left out together.
fn groups<'a>(scores: &'a [BlockScore], clusters: Option<&[usize]>) -> Vec<Vec<&'a BlockScore>> {
    let is_filled = |block: &&BlockScore| block.information.trace() > 0.0;
    let Some(clusters) = clusters else {
        let filled = scores.iter().filter(is_filled);
        return filled.map(|block| vec![block]).collect();
    };
    let last = clusters.iter().copied().max().unwrap_or(0);
    let each = (0..=last).map(|cluster| {
        let own = clusters.iter().zip(scores).filter(|(c, _)| **c == cluster);
        own.map(|(_, block)| block).filter(is_filled).collect()
    });
    each.filter(|group: &Vec<&BlockScore>| !group.is_empty())
        .collect()
}

/// Jackknife variance of each parameter.
fn jackknife(left_out: &[DVector<f64>]) -> DVector<f64> {
    let count = left_out.len() as f64;
    let n = left_out.first().map_or(0, |one| one.len());
    let mean = left_out
        .iter()
        .fold(DVector::zeros(n), |sum, one| sum + one)
        / count.max(1.0);
    let squares = left_out.iter().map(|one| {
        let off = one - &mean;
        off.component_mul(&off)
    });
    squares.fold(DVector::zeros(n), |sum, one| sum + one) * ((count - 1.0) / count)
}

/// What is known of a fit.
#[derive(Debug, Clone)]
pub(crate) struct Precision {
    /// Covariance of the free parameters, in the order of `Fit::free`.
    pub(crate) covariance: DMatrix<f64>,
    /// The same of independent errors.
    pub(crate) expected: DMatrix<f64>,
    /// Variance of each over the model's.
    pub(crate) dispersion: Vec<f64>,
}

impl Precision {
    /// Overdispersion of the parameters at these places: the geometric mean of variance over the model's, at
    /// least 1.
    pub(crate) fn overdispersion(&self, places: &[usize]) -> f64 {
        let logs: f64 = places
            .iter()
            .map(|place| self.dispersion[*place].ln())
            .sum();
        (logs / places.len().max(1) as f64).exp().max(1.0)
    }

    /// The precision of `fit`, `None` where no data depend on it; `physics` counts the leading free parameters that are no noise sizes.
    pub(crate) fn new(problem: &Problem<'_>, fit: &Fit, physics: usize) -> Option<Self> {
        let scores = problem.likelihood.score(&fit.at, &fit.free);
        let (gradient, information) = problem.total(&scores, &fit.at, &fit.free);
        let model = raised(&information)?.inverse();
        let runs = problem.likelihood.run_of();
        let filled: Vec<(usize, &BlockScore)> = runs
            .iter()
            .copied()
            .zip(&scores)
            .filter(|(_, s)| s.information.trace() > 0.0)
            .collect();
        let point = DVector::from_iterator(fit.free.len(), fit.free.iter().map(|i| fit.at[*i]));
        let leave_out = |gone: &[&BlockScore]| {
            let (mut rest, mut left) = (information.clone(), gradient.clone());
            for block in gone {
                rest -= &block.information;
                left -= &block.gradient;
            }
            let mut step = raised(&rest)?.solve(&left);
            for i in 0..step.len() {
                let own = CLIP * model[(i, i)].sqrt();
                let most = if i < physics { own } else { NOISE_CLIP };
                step[i] = step[i].clamp(-most, most);
            }
            Some(&point + step)
        };
        let clusters = problem.likelihood.clusters();
        let groups = groups(&scores, clusters);
        if groups.is_empty() {
            return None;
        }
        let left_out: Vec<DVector<f64>> = groups
            .iter()
            .map(|group| leave_out(group))
            .collect::<Option<_>>()?;
        let mut spread = jackknife(&left_out);
        let last = runs.last().map_or(0, |run| run + 1);
        if last >= LEAST_RUNS {
            let of = |run: usize| {
                let own = filled.iter().filter(|(r, _)| *r == run).map(|(_, b)| *b);
                leave_out(&own.collect::<Vec<_>>())
            };
            let runs: Vec<DVector<f64>> = (0..last).map(of).collect::<Option<_>>()?;
            let between = jackknife(&runs);
            for (i, index) in fit.free.iter().enumerate() {
                if problem.likelihood.is_shared(*index) {
                    spread[i] = spread[i].max(between[i]);
                }
            }
        }
        let n = fit.free.len();
        let mut scale = DVector::zeros(n);
        let mut dispersion = Vec::with_capacity(n);
        for i in 0..n {
            let own = fit.free[i];
            let prior = problem.priors[own].precision(fit.at[own]);
            let from_prior = model[(i, i)] * model[(i, i)] * prior;
            let ratio = ((spread[i] + from_prior) / model[(i, i)]).max(LEAST_SHARE);
            scale[i] = ratio.sqrt();
            dispersion.push(ratio);
        }
        let covariance = DMatrix::from_fn(n, n, |i, k| model[(i, k)] * scale[i] * scale[k]);
        Some(Self {
            covariance,
            expected: model,
            dispersion,
        })
    }
}
