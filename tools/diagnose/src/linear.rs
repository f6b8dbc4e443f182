//! Least squares to first order: windows with unknown starts of their own and parameters that all
//! share. The starts are eliminated window by window (Schur complement), so that the price grows
//! with the length of the recording alone.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use crate::track::CHANNELS;
use crate::window::{LOCALS, Window};

type Own = SMatrix<f64, LOCALS, LOCALS>;

/// What one window says to first order: residuals, and how they move with each unknown of the start
/// and each shared parameter.
#[derive(Debug, Clone, Default)]
pub(crate) struct Linear {
    pub(crate) residuals: Vec<f64>,
    pub(crate) locals: Vec<Vec<f64>>,
    pub(crate) globals: Vec<Vec<f64>>,
}

/// Normal equations of one window.
pub(crate) struct Normal {
    own: Own,
    cross: DMatrix<f64>,
    global: DMatrix<f64>,
    own_slope: SVector<f64, LOCALS>,
    global_slope: DVector<f64>,
}

/// A step of all unknowns.
pub(crate) struct Step {
    pub(crate) globals: Vec<f64>,
    pub(crate) locals: Vec<[f64; LOCALS]>,
}

/// What is known of a derivative: nothing where a residual fell out of the window.
fn known(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

impl Normal {
    /// How much the sum of squares falls by `step`, taken on these equations alone.
    pub(crate) fn decrease(&self, step: &Step) -> f64 {
        let without = damped(&self.own, 0.0);
        let own = (self.own_slope.transpose() * without * self.own_slope)[(0, 0)];
        let globals = DVector::from_column_slice(&step.globals);
        let locals = SVector::<f64, LOCALS>::from_column_slice(&step.locals[0]);
        let all = -(self.own_slope.dot(&locals) + self.global_slope.dot(&globals));
        all - own
    }

    /// Holds each shared parameter near zero with this weight.
    pub(crate) fn believe(&mut self, weight: impl Fn(usize) -> f64) {
        for i in 0..self.global_slope.len() {
            self.global[(i, i)] += weight(i);
        }
    }
}

impl Linear {
    /// The same with the start alone unknown.
    pub(crate) fn without_globals(&self) -> Self {
        Self {
            globals: Vec::new(),
            ..self.clone()
        }
    }

    /// The normal equations under these weights of the channels. `base` are residuals in place of
    /// its own, `more` further shared parameters behind its own.
    pub(crate) fn normal(
        &self,
        window: &Window,
        weights: &[f64; CHANNELS],
        base: &[f64],
        more: &[&[f64]],
    ) -> Normal {
        let shared: Vec<&[f64]> = self
            .globals
            .iter()
            .map(Vec::as_slice)
            .chain(more.iter().copied())
            .collect();
        let count = shared.len();
        let mut normal = Normal {
            own: Own::zeros(),
            cross: DMatrix::zeros(LOCALS, count),
            global: DMatrix::zeros(count, count),
            own_slope: SVector::zeros(),
            global_slope: DVector::zeros(count),
        };
        let mut row = vec![0.0; LOCALS + count];
        for (i, residual) in base.iter().enumerate() {
            if !residual.is_finite() {
                continue;
            }
            let weight = weights[usize::from(window.channels[i])];
            for (cell, column) in row.iter_mut().zip(&self.locals) {
                *cell = known(column[i]);
            }
            for (cell, column) in row[LOCALS..].iter_mut().zip(&shared) {
                *cell = known(column[i]);
            }
            for a in 0..LOCALS {
                let scaled = row[a] * weight;
                if scaled == 0.0 {
                    continue;
                }
                normal.own_slope[a] += scaled * residual;
                for (b, cell) in row[..=a].iter().enumerate() {
                    normal.own[(a, b)] += scaled * cell;
                }
                for b in 0..count {
                    normal.cross[(a, b)] += scaled * row[LOCALS + b];
                }
            }
            for a in 0..count {
                let scaled = row[LOCALS + a] * weight;
                normal.global_slope[a] += scaled * residual;
                for b in 0..=a {
                    normal.global[(a, b)] += scaled * row[LOCALS + b];
                }
            }
        }
        normal.own.fill_upper_triangle_with_lower_triangle();
        if count > 0 {
            normal.global.fill_upper_triangle_with_lower_triangle();
        }
        normal
    }

    /// Residuals after a step, to first order.
    pub(crate) fn predicted(
        &self,
        base: &[f64],
        more: &[&[f64]],
        locals: &[f64; LOCALS],
        globals: &[f64],
    ) -> Vec<f64> {
        let shared = self
            .globals
            .iter()
            .map(Vec::as_slice)
            .chain(more.iter().copied());
        let own = self.locals.iter().map(Vec::as_slice).zip(locals);
        let all: Vec<(&[f64], f64)> = own
            .chain(shared.zip(globals))
            .map(|(c, s)| (c, *s))
            .filter(|(_, s)| *s != 0.0)
            .collect();
        let mut out = base.to_vec();
        for (column, step) in all {
            for (cell, slope) in out.iter_mut().zip(column) {
                *cell += known(*slope) * step;
            }
        }
        out
    }
}

/// A window's own equations, damped. What the window does not show keeps its value.
fn damped(own: &Own, damping: f64) -> Own {
    let mut matrix = *own;
    for i in 0..LOCALS {
        matrix[(i, i)] = if own[(i, i)] > 0.0 {
            own[(i, i)] * (1.0 + damping)
        } else {
            1.0
        };
    }
    matrix.try_inverse().unwrap_or_else(Own::zeros)
}

/// The equations of the shared parameters with the starts eliminated.
pub(crate) fn reduced(normals: &[Normal], damping: f64) -> (DMatrix<f64>, DVector<f64>) {
    let count = normals.first().map_or(0, |n| n.global_slope.len());
    let mut matrix = DMatrix::zeros(count, count);
    let mut slope = DVector::zeros(count);
    for normal in normals.iter().filter(|_| count > 0) {
        let lever = normal.cross.transpose() * damped(&normal.own, damping);
        matrix += &normal.global - &lever * &normal.cross;
        slope += &normal.global_slope - lever * normal.own_slope;
    }
    (matrix, slope)
}

/// The step to the least squares of the first-order model, damped (Levenberg and Marquardt).
/// `bound` moves the step of a shared parameter to what is allowed.
pub(crate) fn step(normals: &[Normal], damping: f64, bound: impl Fn(usize, f64) -> f64) -> Step {
    let (matrix, slope) = reduced(normals, damping);
    let mut globals = solve(&matrix, &slope, damping);
    // what meets a bound stays there, and the others make the best of it
    let mut fixed = vec![None; globals.len()];
    for _ in 0..globals.len() {
        let met = (0..globals.len()).find(|&i| {
            fixed[i].is_none()
                && (bound(i, globals[i]) - globals[i]).abs() > 1e-12 * globals[i].abs()
        });
        let Some(met) = met else { break };
        fixed[met] = Some(bound(met, globals[met]));
        globals = solve_fixed(&matrix, &slope, damping, &fixed);
    }
    let wide = DVector::from_column_slice(&globals);
    let locals = normals.iter().map(|normal| {
        let slope = normal.own_slope + &normal.cross * &wide;
        let step = damped(&normal.own, damping) * -slope;
        let mut own = [0.0; LOCALS];
        own.copy_from_slice(step.as_slice());
        own
    });
    Step {
        locals: locals.collect(),
        globals,
    }
}

/// The least squares of these equations.
pub(crate) fn solved(matrix: &DMatrix<f64>, slope: &DVector<f64>) -> Vec<f64> {
    solve(matrix, slope, 1e-9)
}

fn solve(matrix: &DMatrix<f64>, slope: &DVector<f64>, damping: f64) -> Vec<f64> {
    solve_fixed(matrix, slope, damping, &vec![None; slope.len()])
}

/// Solves for the parameters that are not fixed; in units of their own sizes, so that small numbers
/// are not lost beside large ones.
fn solve_fixed(
    matrix: &DMatrix<f64>,
    slope: &DVector<f64>,
    damping: f64,
    fixed: &[Option<f64>],
) -> Vec<f64> {
    let free: Vec<usize> = (0..fixed.len())
        .filter(|&i| fixed[i].is_none() && matrix[(i, i)] > 0.0)
        .collect();
    let size: Vec<f64> = free.iter().map(|&i| matrix[(i, i)].sqrt()).collect();
    let own = DMatrix::from_fn(free.len(), free.len(), |a, b| {
        let entry = matrix[(free[a], free[b])] / (size[a] * size[b]);
        if a == b {
            entry * (1.0 + damping) + 1e-12
        } else {
            entry
        }
    });
    let rest = DVector::from_fn(free.len(), |a, _| {
        let row = free[a];
        let given: f64 = (0..fixed.len())
            .filter_map(|b| Some(matrix[(row, b)] * fixed[b]?))
            .sum();
        -(slope[row] + given) / size[a]
    });
    if free.is_empty() {
        return fixed.iter().map(|f| f.unwrap_or(0.0)).collect();
    }
    let solved = own
        .lu()
        .solve(&rest)
        .unwrap_or_else(|| DVector::zeros(free.len()));
    let mut step: Vec<f64> = fixed.iter().map(|f| f.unwrap_or(0.0)).collect();
    for (a, &i) in free.iter().enumerate() {
        step[i] = solved[a] / size[a];
    }
    step
}

/// Share of its own size that a parameter's effect must keep beside everything else that is free.
const DETERMINED: f64 = 1e-7;

/// Deviations of the shared parameters: the larger of what the noise of each residual gives, `excess`
/// times, and what the windows show among each other (the sandwich of Huber, 1967, window by
/// window).
pub(crate) fn deviations(normals: &[Normal], excess: f64) -> Vec<f64> {
    let plain = covariance(normals);
    let count = plain.nrows();
    let mut spread = DMatrix::zeros(count, count);
    for normal in normals.iter().filter(|_| count > 0) {
        let lever = normal.cross.transpose() * damped(&normal.own, 0.0);
        let slope = &normal.global_slope - lever * normal.own_slope;
        spread += &slope * slope.transpose();
    }
    let windows = normals.len() as f64;
    let free = (windows - count as f64).max(1.0);
    let known = plain.map(|v| if v.is_finite() { v } else { 0.0 });
    let sandwich = &known * spread * &known * (windows / free);
    let deviation = |i: usize| {
        (plain[(i, i)] * excess * excess)
            .max(sandwich[(i, i)])
            .max(0.0)
    };
    (0..count).map(|i| deviation(i).sqrt()).collect()
}

/// Covariance of the shared parameters; infinite variance for one that is not determined.
pub(crate) fn covariance(normals: &[Normal]) -> DMatrix<f64> {
    let (matrix, _) = reduced(normals, 0.0);
    let count = matrix.nrows();
    let alone = |i: usize| normals.iter().map(|n| n.global[(i, i)]).sum::<f64>();
    let clear: Vec<usize> = (0..count)
        .filter(|&i| matrix[(i, i)] > DETERMINED * DETERMINED * alone(i))
        .collect();
    let size: Vec<f64> = clear.iter().map(|&i| matrix[(i, i)].sqrt()).collect();
    let mut covariance = DMatrix::from_diagonal_element(count, count, 0.0);
    for i in 0..count {
        covariance[(i, i)] = f64::INFINITY;
    }
    if clear.is_empty() {
        return covariance;
    }
    let own = DMatrix::from_fn(clear.len(), clear.len(), |a, b| {
        matrix[(clear[a], clear[b])] / (size[a] * size[b])
    });
    if let Some(inverse) = own.try_inverse() {
        for (a, &i) in clear.iter().enumerate() {
            for (b, &j) in clear.iter().enumerate() {
                covariance[(i, j)] = inverse[(a, b)] / (size[a] * size[b]);
            }
        }
    }
    covariance
}
