//! How well the parameters of a fit are known: by the model, and by how blocks of time differ.

use nalgebra::{DMatrix, DVector};

use super::fit::{Fit, valued, values};
use super::machine::Machine;
use crate::estimate::blocks::{self, Blocks};
use crate::estimate::cluster::Precision;
use crate::estimate::scoring;
use crate::estimate::{BlockScore, Likelihood, Prior};

/// Standard deviation of a prior that says nothing, in units of a parameter.
const FLAT: f64 = 1e6;

/// Score and information of each block at a fit.
struct Linearised {
    scores: Vec<BlockScore>,
    run_of: Vec<usize>,
}

impl Likelihood for Linearised {
    fn blocks(&self) -> usize {
        self.scores.len()
    }

    fn run_of(&self) -> Vec<usize> {
        self.run_of.clone()
    }

    fn is_shared(&self, _: usize) -> bool {
        true
    }

    fn value(&self, _: &[f64]) -> Vec<f64> {
        vec![0.0; self.scores.len()]
    }

    fn score(&self, _: &[f64], _: &[usize]) -> Vec<BlockScore> {
        self.scores.clone()
    }
}

/// Covariances of the parameters of a fit.
pub(crate) struct Known {
    /// By how blocks differ, at least the model's.
    pub(crate) covariance: DMatrix<f64>,
    /// By the model.
    pub(crate) model: DMatrix<f64>,
    pub(crate) overdispersion: f64,
    pub(crate) blocks: usize,
}

impl Machine {
    pub(crate) fn blocks(&self) -> Vec<Blocks> {
        let mut all: Vec<Blocks> = Vec::new();
        for run in &self.runs {
            let stamps = run.rows.iter().map(|row| row.stamp_s);
            let from_s = stamps.clone().fold(f64::INFINITY, f64::min);
            let to_s = stamps.fold(f64::NEG_INFINITY, f64::max);
            let first = all.last().map_or(0, Blocks::end);
            all.push(Blocks::new([from_s, to_s], first));
        }
        all
    }

    /// How well the parameters of `fit` are known, in the order of [`values`]; `None` where one says
    /// nothing.
    pub(crate) fn known(&self, fit: &Fit) -> Option<Known> {
        let at = values(&fit.hypotheses);
        let (columns, weighted) = self.weighted_jacobian(fit)?;
        let blocks = self.blocks();
        let count = blocks::total(blocks.iter().copied());
        let n = at.len();
        let mut scores = vec![
            BlockScore {
                gradient: DVector::zeros(n),
                information: DMatrix::zeros(n, n),
            };
            count
        ];
        for (place, (stamp_s, run)) in self.stamps.iter().enumerate() {
            let own = &blocks[*run];
            let block = &mut scores[own.first + own.of(*stamp_s)];
            for i in 0..n {
                let a = columns[i][place];
                if a == 0.0 {
                    continue;
                }
                block.gradient[i] -= a * weighted[place];
                for k in 0..n {
                    block.information[(i, k)] += a * columns[k][place];
                }
            }
        }
        let mut information = DMatrix::zeros(n, n);
        for block in &scores {
            information += &block.information;
        }
        let model = information.cholesky()?.inverse();
        let linearised = Linearised {
            scores,
            run_of: blocks::run_of(blocks.iter().copied()),
        };
        let problem = scoring::Problem {
            likelihood: &linearised,
            priors: at
                .iter()
                .map(|mean| Prior {
                    mean: *mean,
                    deviation: FLAT,
                })
                .collect(),
            longest: vec![f64::INFINITY; n],
        };
        let fitted = scoring::Fit {
            at: at.clone(),
            free: (0..n).collect(),
            objective: 0.0,
            converged: true,
        };
        let precision = Precision::new(&problem, &fitted, n)?;
        let mut covariance = precision.covariance;
        for i in 0..n {
            let raise = (model[(i, i)] / covariance[(i, i)]).sqrt().max(1.0);
            for k in 0..n {
                covariance[(i, k)] *= raise;
                covariance[(k, i)] *= raise;
            }
        }
        Some(Known {
            covariance,
            model,
            overdispersion: precision.overdispersion,
            blocks: count,
        })
    }

    /// Derivatives of the innovations by each parameter, and the innovations, both over the roots of
    /// their levels.
    fn weighted_jacobian(&self, fit: &Fit) -> Option<(Vec<Vec<f64>>, Vec<f64>)> {
        let at = values(&fit.hypotheses);
        let parameters = super::fit::parameters(&fit.hypotheses);
        let innovations = |at: &[f64]| self.innovations(fit, &valued(&fit.hypotheses, at));
        let problem = super::gauss_newton::Problem {
            parameters: &parameters,
            channels: &self.channels,
            innovations: &innovations,
        };
        let solution = problem.fit(&at, None, 0, 0.0)?;
        // once to learn the steps, once with them
        let weights = problem.weights(&solution.whitened);
        let mut steps = solution.steps;
        let mut columns = Vec::new();
        for _ in 0..2 {
            columns = problem.jacobian(&at, &solution.whitened, &steps)?;
            for column in &mut columns {
                for (own, weight) in column.iter_mut().zip(&weights) {
                    *own *= weight;
                }
            }
            problem.set_steps(&columns, &mut steps);
        }
        let weighted = solution.whitened.iter().zip(&weights);
        Some((columns, weighted.map(|(e, w)| e * w).collect()))
    }
}
