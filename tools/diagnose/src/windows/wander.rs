//! Forces without pattern: one along the body and a moment about the vertical that wander as
//! Ornstein and Uhlenbeck (1930) have it, of a level and a memory that the residuals ask for.
//!
//! Such forces follow any variable a little, and no sensor's noise covers them. What is claimed
//! beside them has to be likelier than more of them: −2 ln L with the forces integrated out, which is
//! what a Kalman smoother over the same states would give.

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use crate::windows::bench::{Bench, Node};
use crate::windows::force::{self, Answers};
use crate::windows::linear::{self, Linear};
use crate::windows::window::{LOCALS, PULSE_S, Window};

/// Pulses that count as one here.
pub(crate) const GROUP: usize = 2;
/// How long that is (s).
pub(crate) const PIECE_S: f64 = PULSE_S * GROUP as f64;
/// Factors by which levels are searched, from coarse to fine.
const FACTORS: [f64; 3] = [4.0, 2.0, 1.3];
/// Correlation times that can be told from a constant in a window, and from white noise (s).
const MEMORY_S: [f64; 2] = [0.05, 10.0];
/// Least force that is looked for: acceleration of the robot (m/s², rad/s²).
const LEAST: [f64; 2] = [1e-5, 1e-4];
/// Mean square of residuals (square deviations) up to which forces without pattern explain them.
pub(crate) const EXPLAINED: f64 = 1.1;
/// Share of the weight up to which they need no explanation: a fifth or less of what rolling takes.
const SMALL: f64 = 0.002;
/// Fall of −2 ln L from which on a level is likelier than another.
const LIKELIER: f64 = 0.1;

/// How much wandering forces do, and how long they last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Level {
    /// Deviation of the force along (N) and of the moment about (N m).
    pub(crate) size: [f64; 2],
    /// Correlation time (s).
    pub(crate) memory_s: f64,
}

/// Wandering forces, and how likely the residuals are under them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wander {
    pub(crate) level: Level,
    /// −2 ln L, up to a constant of the recording.
    pub(crate) deviance: f64,
    /// Mean square of the residuals as such forces would leave them (square deviations): one where
    /// they explain all.
    pub(crate) rest: f64,
}

/// Residuals around a node, ready to be judged under wandering forces.
pub(crate) struct Judge {
    windows: Vec<Products>,
    pub(crate) answers: Vec<Answers>,
    least: [f64; 2],
    knows_noise: bool,
}

/// One window's products of residuals and of their slopes: starts, pulses along, pulses about, then
/// what all windows share.
struct Products {
    matrix: DMatrix<f64>,
    slope: DVector<f64>,
    square: f64,
    rows: usize,
    pulses: usize,
}

/// The same for pieces of several pulses, as far as forces act there, and with what else is shared.
struct Pieces {
    matrix: DMatrix<f64>,
    slope: DVector<f64>,
    square: f64,
    rows: usize,
    /// The pieces in which forces act.
    active: Range<usize>,
}

/// What a window says of the unknowns that all share, its own integrated out.
struct Reduced {
    square: f64,
    volume: f64,
    matrix: DMatrix<f64>,
    slope: DVector<f64>,
}

impl Wander {
    /// Whether forces so small that a floor or a motor may well have them explain all residuals. How
    /// exactly wheels turn as they are told nobody knows.
    pub(crate) fn is_noise(&self, bench: &Bench) -> bool {
        if bench.lacks_motion() {
            return false;
        }
        let [along, about] = self.strengths(bench);
        self.rest < EXPLAINED && along.max(about) < SMALL
    }

    /// Force and moment over the weight, and over the weight at a wheel's distance; of a motion, what
    /// each is at a wheel (m/s).
    pub(crate) fn strengths(&self, bench: &Bench) -> [f64; 2] {
        let [body_kg, _] = force::inertia(bench);
        let wheels_kg = 2.0 * bench.model.robot.wheel_mass_kg.unwrap_or(0.0);
        let weight_n = 9.81 * (body_kg + wheels_kg);
        let [along, about] = self.level.size;
        let b = bench.model.robot.half_track_m;
        match bench.lacks_motion() {
            true => [along, about * b],
            false => [along / weight_n, about / (weight_n * b)],
        }
    }
}

impl Judge {
    pub(crate) fn new(bench: &Bench, node: &Node) -> Option<Self> {
        Some(Self::over(bench, node, force::answers(bench, node, 1.0)?))
    }

    /// The same with what is known of how measurements answer.
    pub(crate) fn over(bench: &Bench, node: &Node, answers: Vec<Answers>) -> Self {
        let windows = bench.windows.par_iter().zip(&node.fit.linear).zip(&answers);
        let windows = windows.map(|((w, linear), answers)| Products::new(w, linear, answers));
        let [along, about] = force::inertia(bench);
        Self {
            windows: windows.collect(),
            answers,
            least: [LEAST[0] * along, LEAST[1] * about],
            knows_noise: bench.knows_noise(),
        }
    }

    /// The likeliest wandering forces beside what the node has.
    pub(crate) fn alone(&self) -> Option<Wander> {
        self.within(&self.everywhere(), self.begin())
    }

    /// ln L that forces as these bring over next to none.
    pub(crate) fn gain(&self, wander: &Wander) -> Option<f64> {
        let least = Level {
            size: self.least,
            ..wander.level
        };
        let nothing: Vec<_> = self.windows.iter().map(Products::nothing).collect();
        let none = self.beside(&self.everywhere(), &nothing, least, false)?;
        Some((none.deviance - wander.deviance) / 2.0)
    }

    /// All pieces of each window.
    pub(crate) fn everywhere(&self) -> Vec<Range<usize>> {
        self.windows.iter().map(|own| 0..own.count()).collect()
    }

    /// Forces that wander as `level` says in the `active` pieces of each window beside one with a free weight for each column of `mixes`:
    /// of each window, what a unit of each is in pulses, those along before those about. `searched`
    /// looks for the likeliest level from there.
    pub(crate) fn beside(
        &self,
        active: &[Range<usize>],
        mixes: &[DMatrix<f64>],
        level: Level,
        searched: bool,
    ) -> Option<Wander> {
        let windows = self.windows.par_iter().zip(mixes).zip(active);
        let windows: Vec<Pieces> = windows
            .map(|((own, mix), active)| own.pieces(mix, active.clone()))
            .collect();
        if searched {
            self.likeliest(&windows, level)
        } else {
            self.judged(&windows, level)
        }
    }

    /// Forces that act in these pieces of each window alone.
    pub(crate) fn within(&self, active: &[Range<usize>], from: Level) -> Option<Wander> {
        let windows = self.windows.iter().zip(active);
        let windows: Vec<Pieces> = windows
            .map(|(own, active)| own.pieces(&own.nothing(), active.clone()))
            .collect();
        self.likeliest(&windows, from)
    }

    /// The likeliest force along (N) and moment about (N m) in each piece of each window under
    /// wandering forces of `level`.
    pub(crate) fn forces(&self, level: &Level) -> Option<Vec<Vec<[f64; 2]>>> {
        let windows = self.windows.iter();
        let windows: Vec<Pieces> = windows
            .map(|own| own.pieces(&own.nothing(), 0..own.count()))
            .collect();
        let parts: Option<Vec<Reduced>> = windows.par_iter().map(|w| w.reduced(level)).collect();
        let (matrix, slope) = summed(&parts?)?;
        let shared = linear::solved(&matrix, &slope);
        windows
            .par_iter()
            .map(|w| w.forces(level, &shared))
            .collect()
    }

    fn begin(&self) -> Level {
        Level {
            size: self.least.map(|least| least * 1e3),
            memory_s: 0.5,
        }
    }

    /// Searches the level, each number by itself, by ever smaller factors.
    fn likeliest(&self, windows: &[Pieces], from: Level) -> Option<Wander> {
        let mut best = self.judged(windows, from)?;
        for factor in FACTORS {
            loop {
                let before = best.deviance;
                for (which, by) in (0..3).flat_map(|i| [(i, factor), (i, 1.0 / factor)]) {
                    while let Some(next) = self
                        .moved(&best.level, which, by)
                        .and_then(|level| self.judged(windows, level))
                        .filter(|next| next.deviance < best.deviance - LIKELIER)
                    {
                        best = next;
                    }
                }
                if best.deviance > before - LIKELIER {
                    break;
                }
            }
        }
        Some(best)
    }

    /// Forces of `level` beside all windows, with the shared unknowns at their best.
    fn judged(&self, windows: &[Pieces], level: Level) -> Option<Wander> {
        let parts: Option<Vec<Reduced>> = windows.par_iter().map(|w| w.reduced(&level)).collect();
        let parts = parts?;
        let (matrix, slope) = summed(&parts)?;
        let own: f64 = parts.iter().map(|part| part.square).sum();
        let volume: f64 = parts.iter().map(|part| part.volume).sum();
        let step = linear::solved(&matrix, &slope);
        let fall: f64 = step.iter().zip(&slope).map(|(step, s)| -step * s).sum();
        let rows: usize = windows.iter().map(|w| w.rows).sum();
        let rest = (own - fall) / rows.max(1) as f64;
        // noise that is not known is what is left, and forces are in proportion to it
        let misfit = match self.knows_noise {
            true => own - fall,
            false => rows as f64 * rest.ln(),
        };
        Some(Wander {
            level,
            deviance: misfit + volume,
            rest,
        })
    }

    /// `level` with one of its numbers multiplied, as far as it may go.
    fn moved(&self, level: &Level, which: usize, by: f64) -> Option<Level> {
        let mut next = *level;
        match next.size.get_mut(which) {
            Some(size) => {
                *size *= by;
                (*size >= self.least[which]).then_some(next)
            }
            None => {
                next.memory_s *= by;
                let [shortest, longest] = MEMORY_S;
                (shortest..=longest)
                    .contains(&next.memory_s)
                    .then_some(next)
            }
        }
    }
}

impl Products {
    fn new(window: &Window, linear: &Linear, answers: &Answers) -> Self {
        let own = linear.locals.iter().map(Vec::as_slice);
        let pulses = answers
            .along
            .iter()
            .chain(&answers.about)
            .map(Vec::as_slice);
        let shared = linear.globals.iter().map(Vec::as_slice);
        let columns: Vec<&[f64]> = own.chain(pulses).chain(shared).collect();
        let used: Vec<usize> = (0..window.channels.len())
            .filter(|i| linear.residuals[*i].is_finite())
            .collect();
        let slopes = DMatrix::from_fn(used.len(), columns.len(), |row, column| {
            linear::known(columns[column][used[row]])
        });
        let residuals = DVector::from_fn(used.len(), |row, _| linear.residuals[used[row]]);
        Self {
            slope: slopes.tr_mul(&residuals),
            matrix: slopes.tr_mul(&slopes),
            square: residuals.norm_squared(),
            rows: used.len(),
            pulses: answers.along.len(),
        }
    }

    /// How many pieces the window has.
    fn count(&self) -> usize {
        self.pulses.div_ceil(GROUP)
    }

    fn nothing(&self) -> DMatrix<f64> {
        DMatrix::zeros(2 * self.pulses, 0)
    }

    /// Forces in the `active` pieces, and further shared unknowns, each a mix of pulses.
    fn pieces(&self, mix: &DMatrix<f64>, active: Range<usize>) -> Pieces {
        let (had, more, pulses) = (self.slope.len(), mix.ncols(), 2 * self.pulses);
        let acting = active.len();
        let shared = LOCALS + 2 * acting;
        let place = |i: usize| match i.checked_sub(LOCALS) {
            None => Some(i),
            Some(k) if k >= pulses => Some(shared + k - pulses),
            Some(k) => {
                let (part, piece) = (k / self.pulses, k % self.pulses / GROUP);
                let at = || LOCALS + part * acting + piece - active.start;
                active.contains(&piece).then(at)
            }
        };
        let size = shared + (had - LOCALS - pulses) + more;
        let first = size - more;
        let mut matrix = DMatrix::zeros(size, size);
        let mut slope = DVector::zeros(size);
        let towards = self.matrix.columns(LOCALS, pulses) * mix;
        let places: Vec<Option<usize>> = (0..had).map(place).collect();
        for (b, to_b) in places.iter().enumerate() {
            let Some(to_b) = *to_b else { continue };
            slope[to_b] += self.slope[b];
            for (a, to_a) in places.iter().enumerate() {
                if let Some(to_a) = *to_a {
                    matrix[(to_a, to_b)] += self.matrix[(a, b)];
                }
            }
            for k in 0..more {
                matrix[(to_b, first + k)] += towards[(b, k)];
                matrix[(first + k, to_b)] += towards[(b, k)];
            }
        }
        let corner = mix.tr_mul(&towards.rows(LOCALS, pulses));
        matrix
            .view_mut((first, first), (more, more))
            .copy_from(&corner);
        let own = mix.tr_mul(&self.slope.rows(LOCALS, pulses));
        slope.rows_mut(first, more).copy_from(&own);
        Pieces {
            matrix,
            slope,
            square: self.square,
            rows: self.rows,
            active,
        }
    }
}

impl Pieces {
    /// How many unknowns the window has for itself.
    fn own(&self) -> usize {
        LOCALS + 2 * self.active.len()
    }

    /// The products of what the window has for itself with what is believed of forces of `level`,
    /// factored, and the logarithm of the volume that is integrated over.
    fn factored(&self, level: &Level) -> Option<(Cholesky<f64, Dyn>, f64)> {
        let own = self.own();
        let mut matrix = self.matrix.view((0, 0), (own, own)).into_owned();
        for i in 0..LOCALS {
            if matrix[(i, i)] == 0.0 {
                matrix[(i, i)] = 1.0;
            }
        }
        let acting = self.active.len();
        let mut volume = 0.0;
        for part in 0..2 {
            let at = LOCALS + part * acting;
            volume += believe(&mut matrix, at, acting, level.size[part], level.memory_s);
        }
        let factor = Cholesky::new(matrix)?;
        let diagonal = factor.l_dirty().diagonal();
        volume += diagonal.iter().map(|d| 2.0 * d.ln()).sum::<f64>();
        Some((factor, volume))
    }

    /// What is left when start and forces of `level` are integrated out. `None` where the numbers do
    /// not suffice.
    fn reduced(&self, level: &Level) -> Option<Reduced> {
        let own = self.own();
        let shared = self.slope.len() - own;
        let (factor, volume) = self.factored(level)?;
        let slope = self.slope.rows(0, own);
        let cross = self.matrix.view((0, own), (own, shared));
        let moved = factor.solve(&slope);
        let lever = factor.solve(&cross);
        Some(Reduced {
            square: self.square - slope.dot(&moved),
            volume,
            matrix: self.matrix.view((own, own), (shared, shared)) - cross.tr_mul(&lever),
            slope: self.slope.rows(own, shared) - cross.tr_mul(&moved),
        })
    }

    /// The likeliest force along and moment about in each piece.
    fn forces(&self, level: &Level, shared: &[f64]) -> Option<Vec<[f64; 2]>> {
        let own = self.own();
        let (factor, _) = self.factored(level)?;
        let cross = self.matrix.view((0, own), (own, shared.len()));
        let slope = self.slope.rows(0, own) + cross * DVector::from_column_slice(shared);
        let own = factor.solve(&-slope);
        let acting = self.active.len();
        let forces = (0..acting).map(|k| [own[LOCALS + k], own[LOCALS + acting + k]]);
        Some(forces.collect())
    }
}

/// Adds what is believed of `count` forces of size `size` before anything is measured; returns the
/// logarithm of the determinant of their covariance.
fn believe(matrix: &mut DMatrix<f64>, first: usize, count: usize, size: f64, memory_s: f64) -> f64 {
    let alike = (-PIECE_S / memory_s).exp();
    let fresh = 1.0 - alike * alike;
    let weight = 1.0 / (size * size * fresh);
    for k in first..first + count {
        matrix[(k, k)] += weight;
        if k > first {
            // what follows another is new only as far as it is not alike
            matrix[(k - 1, k - 1)] += weight * alike * alike;
            matrix[(k - 1, k)] -= weight * alike;
            matrix[(k, k - 1)] -= weight * alike;
        }
    }
    if count > 0 {
        // the first follows nothing
        matrix[(first, first)] -= weight * alike * alike;
    }
    2.0 * count as f64 * size.ln() + count.saturating_sub(1) as f64 * fresh.ln()
}

/// The equations of what all windows share.
fn summed(parts: &[Reduced]) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let count = parts.first()?.slope.len();
    let (mut matrix, mut slope) = (DMatrix::zeros(count, count), DVector::zeros(count));
    for part in parts {
        matrix += &part.matrix;
        slope += &part.slope;
    }
    Some((matrix, slope))
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use crate::windows::fixture::numbers;

    use super::{GROUP, Judge, LOCALS, Level, PIECE_S, Products, believe};

    fn covariance(count: usize, size: f64, memory_s: f64) -> DMatrix<f64> {
        DMatrix::from_fn(count, count, |a, b| {
            size * size * (-PIECE_S * (a as f64 - b as f64).abs() / memory_s).exp()
        })
    }

    #[test]
    fn what_is_believed_is_the_inverse_of_an_ornstein_uhlenbeck_covariance() {
        let mut matrix = DMatrix::zeros(6, 6);
        let volume = believe(&mut matrix, 0, 6, 0.3, 0.2);
        let covariance = covariance(6, 0.3, 0.2);
        assert!((volume - covariance.determinant().ln()).abs() < 1e-9);
        let one = matrix * covariance;
        assert!((one - DMatrix::identity(6, 6)).amax() < 1e-9);
    }

    /// Differences of −2 ln L between levels are those of the normal distribution with the dense
    /// covariance of the forces, start and shared unknown integrated or fitted.
    #[test]
    fn the_likelihood_is_that_of_the_dense_covariance() {
        let (rows, pulses) = (40, 4);
        let mut next = numbers(7);
        let mut columns = |count: usize| DMatrix::from_fn(rows, count, |_, _| next());
        let (starts, forces, shared) = (columns(2), columns(2 * pulses), columns(1));
        let residuals = columns(1).column(0) * 3.0;
        let mut slopes = DMatrix::zeros(rows, LOCALS + 2 * pulses + 1);
        slopes.columns_mut(0, 2).copy_from(&starts);
        slopes.columns_mut(LOCALS, 2 * pulses).copy_from(&forces);
        slopes
            .columns_mut(LOCALS + 2 * pulses, 1)
            .copy_from(&shared);
        let judge = |knows_noise: bool| Judge {
            windows: vec![Products {
                matrix: slopes.tr_mul(&slopes),
                slope: slopes.tr_mul(&residuals),
                square: residuals.norm_squared(),
                rows,
                pulses,
            }],
            answers: Vec::new(),
            least: [1e-6; 2],
            knows_noise,
        };
        let found = |knows_noise: bool, level: Level| {
            let judge = judge(knows_noise);
            let everywhere = judge.everywhere();
            let none = DMatrix::zeros(2 * pulses, 0);
            judge.beside(&everywhere, &[none], level, false).unwrap()
        };
        let dense = |knows_noise: bool, level: Level| {
            let pieces = pulses / GROUP;
            let together = DMatrix::from_fn(pulses, pieces, |pulse, piece| {
                f64::from(u8::from(pulse / GROUP == piece))
            });
            let mut spread = DMatrix::identity(rows, rows);
            for part in 0..2 {
                let own = forces.columns(part * pulses, pulses) * &together;
                spread +=
                    &own * covariance(pieces, level.size[part], level.memory_s) * own.transpose();
            }
            let inverse = spread.clone().try_inverse().unwrap();
            // generalised least squares for starts (integrated) and what is shared (fitted)
            let mut all = DMatrix::zeros(rows, 3);
            all.columns_mut(0, 2).copy_from(&starts);
            all.columns_mut(2, 1).copy_from(&shared);
            let weight = all.tr_mul(&(&inverse * &all));
            let slope: DVector<f64> = all.tr_mul(&(&inverse * &residuals));
            let fall = slope.dot(
                &weight
                    .try_inverse()
                    .unwrap()
                    .column_iter()
                    .enumerate()
                    .fold(DVector::zeros(3), |sum, (i, column)| {
                        sum + column * slope[i]
                    }),
            );
            let square = residuals.dot(&(&inverse * &residuals)) - fall;
            let of_starts = starts.tr_mul(&(&inverse * &starts)).determinant().ln();
            let volume = spread.determinant().ln() + of_starts;
            // of noise that is not known the likeliest variance is the mean square
            let misfit = match knows_noise {
                true => square,
                false => rows as f64 * square.ln(),
            };
            misfit + volume
        };
        let levels = [[0.1, 0.2], [1.0, 0.05], [3.0, 2.0]].map(|size| Level {
            size,
            memory_s: 0.4,
        });
        for (pair, knows_noise) in levels
            .windows(2)
            .flat_map(|pair| [(pair, true), (pair, false)])
        {
            let own = found(knows_noise, pair[1]).deviance - found(knows_noise, pair[0]).deviance;
            let known = dense(knows_noise, pair[1]) - dense(knows_noise, pair[0]);
            assert!((own - known).abs() < 1e-6, "{own} {known}");
        }
    }
}
