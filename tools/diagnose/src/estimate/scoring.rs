//! Penalised maximum likelihood by Fisher scoring with Levenberg-Marquardt damping.
//!
//! Physics and noise sizes are estimated together: a search that alternates between them stops short
//! where they trade, and an unfinished fit is the commonest wrong name.

use nalgebra::{DMatrix, DVector};

use super::{BlockScore, Likelihood, Prior};

/// Limits of a search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SearchLimits {
    /// Most iterations.
    pub(crate) iterations: usize,
    /// The search ends when an iteration gains less (nats).
    pub(crate) tolerance_nats: f64,
}

/// A fit that has converged unless the tolerance says otherwise.
pub(crate) const FULL: SearchLimits = SearchLimits {
    iterations: 40,
    tolerance_nats: 0.02,
};
/// A fit that ranks starts.
pub(crate) const SHORT: SearchLimits = SearchLimits {
    iterations: 8,
    tolerance_nats: 1.0,
};

/// Largest step of scoring down in the log of a noise size: a size that explains nothing has one half.
const LEAST_STEP: f64 = -0.49;

/// Where a search ended.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// All parameters, free or not.
    pub(crate) at: Vec<f64>,
    /// Indices of those that were free.
    pub(crate) free: Vec<usize>,
    /// Log-likelihood plus log-prior (nats).
    pub(crate) objective: f64,
    /// Whether the last iteration gained less than the tolerance.
    pub(crate) converged: bool,
}

impl Fit {
    /// Place of a parameter among the free ones.
    pub(crate) fn place(&self, parameter: usize) -> Option<usize> {
        self.free.iter().position(|own| *own == parameter)
    }

    /// Places of those of `parameters` that are free.
    pub(crate) fn places(&self, parameters: &[usize]) -> Vec<usize> {
        let all = parameters.iter();
        all.filter_map(|index| self.place(*index)).collect()
    }
}

/// Score and information on `count` parameters over all blocks.
pub(crate) fn summed(scores: &[BlockScore], count: usize) -> (DVector<f64>, DMatrix<f64>) {
    let mut gradient = DVector::zeros(count);
    let mut information = DMatrix::zeros(count, count);
    for block in scores {
        gradient += &block.gradient;
        information += &block.information;
    }
    (gradient, information)
}

/// A likelihood with priors on its parameters.
pub(crate) struct Problem<'a> {
    pub(crate) likelihood: &'a dyn Likelihood,
    pub(crate) priors: Vec<Prior>,
    /// Longest step of a parameter in one iteration.
    pub(crate) longest: Vec<f64>,
    /// Logs of noise sizes. A likelihood of n innovations of size s, fitted with σ, is n (ln σ + s² / 2σ²): a scoring
    /// step x leads to its maximum as ½ ln (1 + 2x), whose first order it is.
    pub(crate) sizes: Vec<usize>,
}

impl Problem<'_> {
    /// Log-likelihood plus log-prior of the free parameters (nats).
    pub(crate) fn objective(&self, at: &[f64], free: &[usize]) -> f64 {
        let own: f64 = self.likelihood.value(at).iter().sum();
        own + self.log_prior(at, free)
    }

    pub(crate) fn log_prior(&self, at: &[f64], free: &[usize]) -> f64 {
        free.iter().map(|i| self.priors[*i].log(at[*i])).sum()
    }

    /// Sum of score and information over blocks, priors included.
    pub(crate) fn total(
        &self,
        scores: &[BlockScore],
        at: &[f64],
        free: &[usize],
    ) -> (DVector<f64>, DMatrix<f64>) {
        let (mut gradient, mut information) = summed(scores, free.len());
        for (place, index) in free.iter().enumerate() {
            let prior = &self.priors[*index];
            gradient[place] += (prior.mean - at[*index]) * prior.precision(at[*index]);
        }
        self.add_priors(&mut information, at, free);
        (gradient, information)
    }

    /// Adds what the priors of `free` know at `at` to the information on them, which come first in it.
    pub(crate) fn add_priors(&self, information: &mut DMatrix<f64>, at: &[f64], free: &[usize]) {
        for (place, index) in free.iter().enumerate() {
            information[(place, place)] += self.priors[*index].precision(at[*index]);
        }
    }

    /// Maximises the objective over `free` from `start`.
    pub(crate) fn fit(&self, start: &[f64], free: &[usize], limits: SearchLimits) -> Fit {
        let mut at = start.to_vec();
        let mut objective = self.objective(&at, free);
        let mut damping = 0.1;
        let mut converged = free.is_empty();
        for _ in 0..limits.iterations {
            if converged || !objective.is_finite() {
                break;
            }
            let scores = self.likelihood.score(&at, free);
            let (gradient, information) = self.total(&scores, &at, free);
            let Some((next, step, value)) =
                self.step(&at, free, &gradient, &information, objective, &mut damping)
            else {
                converged = true;
                break;
            };
            let predicted =
                gradient.dot(&step) - 0.5 * (step.transpose() * &information * &step)[(0, 0)];
            let gain = value - objective;
            damping = if gain > 0.5 * predicted {
                (damping / 4.0).max(1e-4)
            } else {
                damping * 2.0
            };
            (at, objective) = (next, value);
            converged = gain < limits.tolerance_nats;
        }
        Fit {
            at,
            free: free.to_vec(),
            objective,
            converged,
        }
    }

    /// One damped step that does not make the objective worse.
    fn step(
        &self,
        at: &[f64],
        free: &[usize],
        gradient: &DVector<f64>,
        information: &DMatrix<f64>,
        objective: f64,
        damping: &mut f64,
    ) -> Option<(Vec<f64>, DVector<f64>, f64)> {
        for _ in 0..8 {
            let mut damped = information.clone();
            for i in 0..free.len() {
                damped[(i, i)] += *damping * information[(i, i)].max(1e-12);
            }
            let Some(factor) = damped.cholesky() else {
                *damping = (*damping * 6.0).max(1e-3);
                continue;
            };
            let mut step = factor.solve(gradient);
            for place in free
                .iter()
                .enumerate()
                .filter(|(_, own)| self.sizes.contains(own))
                .map(|(place, _)| place)
            {
                step[place] = 0.5 * (1.0 + 2.0 * step[place].max(LEAST_STEP)).ln();
            }
            for (place, index) in free.iter().enumerate() {
                step[place] = step[place].clamp(-self.longest[*index], self.longest[*index]);
            }
            let mut next = at.to_vec();
            for (place, index) in free.iter().enumerate() {
                next[*index] += step[place];
            }
            let value = self.objective(&next, free);
            if value.is_finite() && value > objective - 1e-9 {
                return Some((next, step, value));
            }
            *damping = (*damping * 6.0).max(1e-3);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's function as a likelihood of two innovations.
    struct Rosenbrock;

    impl Likelihood for Rosenbrock {
        fn blocks(&self) -> usize {
            1
        }

        fn run_of(&self) -> Vec<usize> {
            vec![0]
        }

        fn is_shared(&self, _: usize) -> bool {
            true
        }

        fn value(&self, at: &[f64]) -> Vec<f64> {
            let [a, b] = [1.0 - at[0], 10.0 * (at[1] - at[0] * at[0])];
            vec![-0.5 * (a * a + b * b)]
        }

        fn score(&self, at: &[f64], free: &[usize]) -> Vec<BlockScore> {
            let e = DVector::from_vec(vec![1.0 - at[0], 10.0 * (at[1] - at[0] * at[0])]);
            let all = DMatrix::from_row_slice(2, 2, &[-1.0, 0.0, -20.0 * at[0], 10.0]);
            let j = DMatrix::from_fn(2, free.len(), |r, c| all[(r, free[c])]);
            vec![BlockScore {
                gradient: -(j.transpose() * &e),
                information: j.transpose() * &j,
            }]
        }
    }

    #[test]
    fn finds_the_minimum_of_a_bent_valley() {
        let flat = Prior {
            mean: 0.0,
            deviation: 1e6,
            has_tails: false,
        };
        let problem = Problem {
            likelihood: &Rosenbrock,
            priors: vec![flat; 2],
            longest: vec![10.0; 2],
            sizes: Vec::new(),
        };
        let limits = SearchLimits {
            iterations: 200,
            tolerance_nats: 1e-12,
        };
        let fit = problem.fit(&[-1.2, 1.0], &[0, 1], limits);
        assert!(fit.converged);
        assert!(
            (fit.at[0] - 1.0).abs() < 1e-4 && (fit.at[1] - 1.0).abs() < 1e-4,
            "{fit:?}"
        );
    }
}
