//! How well the parameters of a fit are known: by the model, and by how blocks of time differ.

use nalgebra::{DMatrix, DVector};

use super::channels::levels;
use super::fit::{Fit, valued, values};
use super::machine::Machine;
use crate::estimate::blocks::{self, Blocks};
use crate::estimate::cluster::Precision;
use crate::estimate::scoring;
use crate::estimate::{BlockScore, Likelihood, Prior};

/// Upper 5 % point of chi-square with one degree of freedom.
const ONE_IN_TWENTY: f64 = 3.841;
/// A profile goes no further than this multiple of a value.
const FAR: f64 = 20.0;
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
    pub(crate) blocks: usize,
}

impl Known {
    /// What is known of these parameters alone.
    pub(crate) fn of(&self, places: &[usize]) -> Self {
        let own = |all: &DMatrix<f64>| {
            DMatrix::from_fn(places.len(), places.len(), |i, k| {
                all[(places[i], places[k])]
            })
        };
        Self {
            covariance: own(&self.covariance),
            model: own(&self.model),
            blocks: self.blocks,
        }
    }
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

    /// How well the parameters of `fit` are known, in the order of [`values`]. What the recording says
    /// nothing of has an infinite variance.
    pub(crate) fn known(&self, fit: &Fit) -> Option<Known> {
        let (columns, weighted) = self.weighted_jacobian(fit)?;
        let all = columns.len();
        let tells = |column: &Vec<f64>| column.iter().map(|x| x * x).sum::<f64>() > 1e-9;
        let told: Vec<usize> = (0..all).filter(|i| tells(&columns[*i])).collect();
        let columns: Vec<&Vec<f64>> = told.iter().map(|i| &columns[*i]).collect();
        let blocks = self.blocks();
        let count = blocks::total(blocks.iter().copied());
        let scores = self.block_scores(&columns, &weighted, &blocks, count);
        let n = told.len();
        let mut information = DMatrix::zeros(n, n);
        for block in &scores {
            information += &block.information;
        }
        let model = raised(&information)?;
        let at = values(&fit.hypotheses);
        let at: Vec<f64> = told.iter().map(|i| at[*i]).collect();
        let linearised = Linearised {
            scores,
            run_of: blocks::run_of(blocks.iter().copied()),
        };
        let flat = |mean: &f64| Prior {
            mean: *mean,
            deviation: FLAT,
            has_tails: false,
        };
        let problem = scoring::Problem {
            likelihood: &linearised,
            priors: at.iter().map(flat).collect(),
            longest: vec![f64::INFINITY; n],
        };
        let fitted = scoring::Fit {
            at,
            free: (0..n).collect(),
            objective: 0.0,
            converged: true,
        };
        let precision = Precision::new(&problem, &fitted, n)?;
        let mut by_blocks = precision.covariance;
        for i in 0..n {
            let raise = (model[(i, i)] / by_blocks[(i, i)]).sqrt().max(1.0);
            for k in 0..n {
                by_blocks[(i, k)] *= raise;
                by_blocks[(k, i)] *= raise;
            }
        }
        let spread = |own: &DMatrix<f64>| {
            let mut out = DMatrix::zeros(all, all);
            for i in 0..all {
                out[(i, i)] = f64::INFINITY;
            }
            for (i, a) in told.iter().enumerate() {
                for (k, b) in told.iter().enumerate() {
                    out[(*a, *b)] = own[(i, k)];
                }
            }
            out
        };
        Some(Known {
            covariance: spread(&by_blocks),
            model: spread(&model),
            blocks: count,
        })
    }

    /// −2 ln L of each block, up to a constant.
    pub(crate) fn by_block(&self, fit: &Fit) -> Vec<f64> {
        let levels = levels(&fit.whitened, &self.channels).map(|[mean, _]| mean.max(1.0));
        let blocks = self.blocks();
        let mut out = vec![0.0; blocks::total(blocks.iter().copied())];
        let place = |stamp_s: f64, run: usize| blocks[run].first + blocks[run].of(stamp_s);
        let all = fit.whitened.iter().zip(&self.channels).zip(&self.stamps);
        for ((e, channel), (stamp_s, run)) in all {
            if let Some(level) = levels.get(usize::from(*channel)) {
                out[place(*stamp_s, *run)] += e * e / level + level.ln();
            }
        }
        let gains = fit.passes.iter().flat_map(|pass| &pass.gains);
        for (gain, row) in gains.zip(self.stamps.chunks(3)) {
            let (stamp_s, run) = row[0];
            out[place(stamp_s, run)] += gain.log_determinant;
        }
        out
    }

    fn block_scores(
        &self,
        columns: &[&Vec<f64>],
        weighted: &[f64],
        blocks: &[Blocks],
        count: usize,
    ) -> Vec<BlockScore> {
        let n = columns.len();
        let empty = BlockScore {
            gradient: DVector::zeros(n),
            information: DMatrix::zeros(n, n),
        };
        let mut scores = vec![empty; count];
        for (place, (stamp_s, run)) in self.stamps.iter().enumerate() {
            let own = &blocks[*run];
            let block = &mut scores[own.first + own.of(*stamp_s)];
            for i in 0..n {
                let a = columns[i][place];
                if a == 0.0 {
                    continue;
                }
                block.gradient[i] -= a * weighted[place];
                for (k, other) in columns.iter().enumerate() {
                    block.information[(i, k)] += a * other[place];
                }
            }
        }
        scores
    }

    /// Where −2 ln L, at the gains of `fit`, has risen by what one parameter takes with 95 %: for what
    /// has no derivative.
    pub(crate) fn profile(&self, fit: &Fit, index: usize, name: &str) -> Option<[f64; 2]> {
        let own = &fit.hypotheses[index];
        let at = own.value(name)?;
        let here = self.deviance(&fit.whitened);
        let rises = |value: f64| {
            let mut all = fit.hypotheses.clone();
            all[index].set(name, value);
            all[index].keep_in_order();
            if all[index].value(name) != Some(value) {
                // static friction is not below kinetic friction
                return true;
            }
            self.innovations(fit, &all)
                .is_none_or(|e| self.deviance(&e) > here + ONE_IN_TWENTY)
        };
        let side = |sign: f64| {
            let mut inside = 0.0;
            let mut outside = 1e-3 * at.abs().max(1e-6);
            while !rises(at + sign * outside) {
                inside = outside;
                outside *= 2.0;
                if outside > at.abs() * FAR {
                    return at + sign * inside;
                }
            }
            for _ in 0..7 {
                let middle = 0.5 * (inside + outside);
                if rises(at + sign * middle) {
                    outside = middle;
                } else {
                    inside = middle;
                }
            }
            at + sign * outside
        };
        Some([side(-1.0), side(1.0)])
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

/// Inverse of an information matrix, which may be singular but for rounding.
fn raised(information: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    [0.0, 1e-9, 1e-6].into_iter().find_map(|share| {
        let mut own = information.clone();
        for i in 0..own.nrows() {
            own[(i, i)] *= 1.0 + share;
        }
        Some(own.cholesky()?.inverse())
    })
}
