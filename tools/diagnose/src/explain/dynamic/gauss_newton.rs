//! Gauss-Newton with Levenberg-Marquardt damping on whitened innovations, derivatives by differences.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::channels::{deviance, levels, weights};

/// Share of a standard deviation over which differences are taken.
const STEP_SHARE: f64 = 0.3;

/// One parameter that is fitted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parameter {
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    /// A small change of it, by which differences begin.
    pub(crate) small: f64,
}

/// A function from parameters to whitened innovations; `None` where no robot has such parameters.
pub(crate) struct Problem<'a> {
    pub(crate) parameters: &'a [Parameter],
    pub(crate) channels: &'a [u8],
    pub(crate) innovations: &'a (dyn Fn(&[f64]) -> Option<Vec<f64>> + Sync),
}

/// Where a fit ended.
pub(crate) struct Solution {
    pub(crate) at: Vec<f64>,
    pub(crate) whitened: Vec<f64>,
    /// −2 ln L up to a constant.
    pub(crate) deviance: f64,
    /// Steps of the differences that were used last.
    pub(crate) steps: Vec<f64>,
}

impl Problem<'_> {
    fn evaluate(&self, at: &[f64]) -> Option<(Vec<f64>, f64)> {
        let whitened = (self.innovations)(at)?;
        let deviance = deviance(&levels(&whitened, self.channels));
        deviance.is_finite().then_some((whitened, deviance))
    }

    /// Derivatives of the innovations by each parameter, over `steps`.
    pub(crate) fn jacobian(
        &self,
        at: &[f64],
        whitened: &[f64],
        steps: &[f64],
    ) -> Option<Vec<Vec<f64>>> {
        let columns = (0..at.len()).into_par_iter().map(|i| {
            let own = &self.parameters[i];
            let mut moved = at.to_vec();
            // away from the bound
            let step = if at[i] + steps[i] > own.upper {
                -steps[i]
            } else {
                steps[i]
            };
            moved[i] += step;
            let seen = (self.innovations)(&moved)?;
            let slope = |(after, before): (&f64, &f64)| (after - before) / step;
            Some(seen.iter().zip(whitened).map(slope).collect::<Vec<f64>>())
        });
        columns.collect()
    }

    /// Weight of each innovation: one over the root of its channel's level.
    pub(crate) fn weights(&self, whitened: &[f64]) -> Vec<f64> {
        weights(whitened, self.channels)
    }

    /// Fits from `start`; ends after `iterations` or when one gains less than `tolerance` (−2 ln L).
    pub(crate) fn fit(
        &self,
        start: &[f64],
        steps: Option<&[f64]>,
        iterations: usize,
        tolerance: f64,
    ) -> Option<Solution> {
        let mut at = start.to_vec();
        self.hold(&mut at);
        let (mut whitened, mut best) = self.evaluate(&at)?;
        let mut steps = match steps {
            Some(steps) => steps.to_vec(),
            None => self.parameters.iter().map(|p| p.small).collect(),
        };
        let mut damping = 1e-3;
        if at.is_empty() {
            return Some(Solution {
                at,
                whitened,
                deviance: best,
                steps,
            });
        }
        for _ in 0..iterations {
            let weights = self.weights(&whitened);
            let Some(mut columns) = self.jacobian(&at, &whitened, &steps) else {
                break;
            };
            for column in &mut columns {
                for (own, weight) in column.iter_mut().zip(&weights) {
                    *own *= weight;
                }
            }
            let weighted: Vec<f64> = whitened.iter().zip(&weights).map(|(e, w)| e * w).collect();
            let (normal, gradient) = normal_equations(&columns, &weighted);
            self.set_steps(&columns, &mut steps);
            let mut next = None;
            for _ in 0..6 {
                let moved = self.moved(&at, &normal, &gradient, damping);
                let found = moved.and_then(|moved| Some((self.evaluate(&moved)?, moved)));
                match found {
                    Some(((e, value), moved)) if value < best => {
                        next = Some((moved, e, value));
                        break;
                    }
                    _ => damping *= 10.0,
                }
            }
            let Some((moved, e, value)) = next else { break };
            let gain = best - value;
            (at, whitened, best) = (moved, e, value);
            damping = (damping / 8.0).max(1e-7);
            if gain < tolerance {
                break;
            }
        }
        Some(Solution {
            at,
            whitened,
            deviance: best,
            steps,
        })
    }

    /// Sets the steps of the differences by how well each parameter is known.
    pub(crate) fn set_steps(&self, columns: &[Vec<f64>], steps: &mut [f64]) {
        for ((step, column), parameter) in steps.iter_mut().zip(columns).zip(self.parameters) {
            let square: f64 = column.iter().map(|x| x * x).sum();
            let deviation = square.max(1e-300).sqrt().recip();
            let small = parameter.small;
            *step = (STEP_SHARE * deviation).clamp(1e-4 * small, 10.0 * small);
        }
    }

    fn hold(&self, at: &mut [f64]) {
        for (own, parameter) in at.iter_mut().zip(self.parameters) {
            *own = own.clamp(parameter.lower, parameter.upper);
        }
    }

    fn moved(
        &self,
        at: &[f64],
        normal: &DMatrix<f64>,
        gradient: &DVector<f64>,
        damping: f64,
    ) -> Option<Vec<f64>> {
        let mut damped = normal.clone();
        let least = 1e-12 * normal.trace().max(1e-300);
        for i in 0..at.len() {
            damped[(i, i)] += damping * normal[(i, i)] + least;
        }
        let step = damped.cholesky()?.solve(gradient);
        let mut moved = at.to_vec();
        for (i, own) in moved.iter_mut().enumerate() {
            *own -= step[i];
        }
        self.hold(&mut moved);
        Some(moved)
    }
}

/// JᵀJ and Jᵀe.
pub(crate) fn normal_equations(
    columns: &[Vec<f64>],
    weighted: &[f64],
) -> (DMatrix<f64>, DVector<f64>) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let n = columns.len();
    let normal = DMatrix::from_fn(n, n, |i, k| dot(&columns[i], &columns[k]));
    let gradient = DVector::from_fn(n, |i, _| dot(&columns[i], weighted));
    (normal, gradient)
}
