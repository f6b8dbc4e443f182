//! Least squares to first order: windows with unknown starts of their own and parameters that all
//! share. The starts are eliminated window by window (Schur complement), so that the price grows
//! with the length of the recording alone.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use crate::windows::track::CHANNELS;
use crate::windows::window::{LOCALS, Window};

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
#[derive(Clone)]
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
pub(crate) fn known(value: f64) -> f64 {
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

    /// What the window tells of a shared parameter alone: the inverse of its variance.
    pub(crate) fn told(&self, i: usize) -> f64 {
        self.global[(i, i)]
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::windows::fixture;

    const WINDOWS: usize = 3;
    const SHARED: usize = 2;
    const ROWS: usize = 40;

    /// Rows of which every other one is of channel 0, and of channel 2.
    fn window() -> Window {
        fixture::window([0, 2].repeat(ROWS / 2))
    }

    fn weights() -> [f64; CHANNELS] {
        let mut weights = [0.0; CHANNELS];
        (weights[0], weights[2]) = (0.5, 3.0);
        weights
    }

    fn some() -> Vec<Linear> {
        let mut number = fixture::numbers(7);
        let mut column = || (0..ROWS).map(|_| number()).collect::<Vec<f64>>();
        let mut one = |_| Linear {
            residuals: column(),
            locals: (0..LOCALS).map(|_| column()).collect(),
            globals: (0..SHARED).map(|_| column()).collect(),
        };
        (0..WINDOWS).map(&mut one).collect()
    }

    fn normals(linear: &[Linear]) -> Vec<Normal> {
        let (window, weights) = (window(), weights());
        let normal = |l: &Linear| l.normal(&window, &weights, &l.residuals, &[]);
        linear.iter().map(normal).collect()
    }

    /// The same problem in one matrix: the shared parameters first, then each window's start. Rows
    /// are scaled by the roots of their weights.
    fn dense(linear: &[Linear]) -> (DMatrix<f64>, DVector<f64>) {
        let (window, weights) = (window(), weights());
        let mut matrix = DMatrix::zeros(WINDOWS * ROWS, SHARED + WINDOWS * LOCALS);
        let mut residuals = DVector::zeros(WINDOWS * ROWS);
        for (w, one) in linear.iter().enumerate() {
            for i in 0..ROWS {
                let root = weights[usize::from(window.channels[i])].sqrt();
                let row = w * ROWS + i;
                residuals[row] = root * one.residuals[i];
                for (at, column) in one.globals.iter().enumerate() {
                    matrix[(row, at)] = root * column[i];
                }
                for (at, column) in one.locals.iter().enumerate() {
                    matrix[(row, SHARED + w * LOCALS + at)] = root * column[i];
                }
            }
        }
        (matrix, residuals)
    }

    fn dense_inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
        (matrix.transpose() * matrix).try_inverse().unwrap()
    }

    #[test]
    fn the_step_without_starts_is_that_of_all_unknowns_together() {
        let linear = some();
        let (matrix, residuals) = dense(&linear);
        let whole = -dense_inverse(&matrix) * matrix.transpose() * residuals;
        let step = step(&normals(&linear), 0.0, |_, step| step);
        let own = step.globals.iter().chain(step.locals.iter().flatten());
        // what keeps a singular matrix solvable is 1e-12 of it
        for (own, whole) in own.zip(whole.iter()) {
            assert!((own - whole).abs() < 1e-9, "{own} for {whole}");
        }
    }

    #[test]
    fn what_meets_a_bound_stays_there_and_the_rest_makes_the_best_of_it() {
        let linear = some();
        let most = 1e-3;
        let step = step(&normals(&linear), 0.0, |i, step| {
            if i == 0 {
                step.clamp(-most, most)
            } else {
                step
            }
        });
        assert_eq!(step.globals[0].abs(), most);
        let (matrix, residuals) = dense(&linear);
        let left = residuals + matrix.column(0) * step.globals[0];
        let rest = matrix.remove_column(0);
        let whole = -dense_inverse(&rest) * rest.transpose() * left;
        assert!((step.globals[1] - whole[0]).abs() < 1e-9);
    }

    #[test]
    fn the_covariance_is_that_of_all_unknowns_together() {
        let linear = some();
        let (matrix, _) = dense(&linear);
        let whole = dense_inverse(&matrix);
        let own = covariance(&normals(&linear));
        for i in 0..SHARED {
            for j in 0..SHARED {
                assert!((own[(i, j)] - whole[(i, j)]).abs() < 1e-9 * whole[(i, i)]);
            }
        }
    }

    #[test]
    fn what_nothing_shows_is_not_determined() {
        let mut linear = some();
        linear.iter_mut().for_each(|l| l.globals[1].fill(0.0));
        let own = covariance(&normals(&linear));
        assert!(own[(0, 0)].is_finite());
        assert!(own[(1, 1)].is_infinite());
    }

    #[test]
    fn windows_that_disagree_make_a_parameter_less_sure() {
        let mut linear = some();
        linear.iter_mut().for_each(|l| l.residuals.fill(0.0));
        let plain = covariance(&normals(&linear));
        let agree = deviations(&normals(&linear), 1.5);
        for i in 0..SHARED {
            assert!((agree[i] / (1.5 * plain[(i, i)].sqrt()) - 1.0).abs() < 1e-9);
        }
        // each window would have the first parameter elsewhere
        for (one, wanted) in linear.iter_mut().zip([-5.0, 0.0, 5.0]) {
            let pairs = one.residuals.iter_mut().zip(&one.globals[0]);
            pairs.for_each(|(residual, slope)| *residual = -wanted * slope);
        }
        let disagree = deviations(&normals(&linear), 1.5);
        assert!(disagree[0] > 3.0 * agree[0], "{disagree:?} {agree:?}");
    }
}
