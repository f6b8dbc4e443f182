//! Score and Fisher information of innovations, from dual numbers.
//!
//! Of a row with innovation ν and covariance S: score ∂ log L, information
//! ∂ν' S⁻¹ ∂ν + ½ tr(S⁻¹ ∂S S⁻¹ ∂S), weighted by the probability that the row is an ordinary one.

use nalgebra::{DMatrix, DVector};
use num_dual::DualSVec64;
use rayon::prelude::*;

use super::BlockScore;
use super::whitened::{WIDTH, Whitened};
use crate::filter::Innovation;
use crate::filter::cholesky::inverse_factor;

/// Derivatives that one pass of a filter carries.
pub(crate) const LANES: usize = 6;
/// A number with derivatives by [`LANES`] parameters.
pub(crate) type Dual = DualSVec64<LANES>;
/// Rows of one filter: derivatives of every row by every local parameter.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    /// Consecutive rows of one block: the block, and where its numbers end in `whitened`.
    pieces: Vec<(usize, usize)>,
    /// For each parameter, piece after piece: weighted derivative of the log-likelihood.
    scores: Vec<Vec<f64>>,
    /// For each parameter, row after row: whitened derivatives.
    pub(super) whitened: Vec<Vec<f64>>,
    /// The rows themselves, where another recording is compared with them.
    pub(super) kept: Vec<Whitened>,
}

impl Rows {
    /// Runs a filter once for every [`LANES`] of `free` (indices into `at`). `run` runs it with
    /// parameters that carry derivatives; `block_of` gives the block of a stamp (s). `keep`: another
    /// recording is compared with the rows.
    pub(crate) fn new(
        at: &[f64],
        free: &[usize],
        keep: bool,
        run: impl Fn(&[Dual], &mut dyn FnMut(Innovation<Dual>)) + Sync,
        block_of: impl Fn(f64) -> usize + Sync,
    ) -> Self {
        let chunks = free.par_chunks(LANES).map(|lanes| {
            let parameters: Vec<Dual> = at
                .iter()
                .enumerate()
                .map(
                    |(index, value)| match lanes.iter().position(|f| *f == index) {
                        Some(lane) => Dual::from_re(*value).derivative(lane),
                        None => Dual::from_re(*value),
                    },
                )
                .collect();
            let mut own = Self {
                pieces: Vec::new(),
                scores: vec![Vec::new(); lanes.len()],
                whitened: vec![Vec::new(); lanes.len()],
                kept: Vec::new(),
            };
            run(&parameters, &mut |row| {
                let block = block_of(row.time_s);
                own.push(&row, block);
                if keep {
                    own.kept.push(Whitened::new(&row.values(), block));
                }
            });
            own
        });
        let mut all = Self::default();
        for own in chunks.collect::<Vec<_>>() {
            all.kept = own.kept;
            all.pieces = own.pieces;
            all.scores.extend(own.scores);
            all.whitened.extend(own.whitened);
        }
        all
    }

    fn push(&mut self, row: &Innovation<Dual>, block: usize) {
        if self.pieces.last().is_none_or(|(last, _)| *last != block) {
            self.pieces.push((block, 0));
            self.scores.iter_mut().for_each(|own| own.push(0.0));
        }
        let derivatives = RowDerivatives::new(row);
        let width = if row.scalar { 2 } else { WIDTH };
        for (lane, whitened) in self.whitened.iter_mut().enumerate() {
            let numbers = derivatives.whitened(lane, row.scalar);
            whitened.extend_from_slice(&numbers[..width]);
            if let Some(score) = self.scores[lane].last_mut() {
                *score += part(&row.log_likelihood, lane) * row.weight;
            }
        }
        let end = self.whitened.first().map_or(0, Vec::len);
        if let Some(piece) = self.pieces.last_mut() {
            piece.1 = end;
        }
    }

    /// Adds the rows to their blocks. `to` pairs a parameter of the rows with its place there; one may have
    /// several.
    pub(crate) fn add_to(&self, blocks: &mut [BlockScore], to: &[(usize, usize)]) {
        let mut from = 0;
        for (piece, (block, end)) in self.pieces.iter().enumerate() {
            let own = &mut blocks[*block];
            for (i, (lane, place)) in to.iter().enumerate() {
                own.gradient[*place] += self.scores[*lane][piece];
                let a = &self.whitened[*lane][from..*end];
                for (k, (second, other)) in to.iter().enumerate().take(i + 1) {
                    let product = dot(a, &self.whitened[*second][from..*end]);
                    own.information[(*place, *other)] += product;
                    if i != k {
                        own.information[(*other, *place)] += product;
                    }
                }
            }
            from = *end;
        }
    }
}

/// Scalar product, in eight sums that a processor can add at once.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_parts, b_parts) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = a_parts.remainder().iter().zip(b_parts.remainder());
    let rest: f64 = rest.map(|(x, y)| x * y).sum();
    for (x, y) in a_parts.zip(b_parts) {
        for i in 0..8 {
            sums[i] += x[i] * y[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Blocks without any row.
pub(crate) fn empty(blocks: usize, parameters: usize) -> Vec<BlockScore> {
    let one = BlockScore {
        gradient: DVector::zeros(parameters),
        information: DMatrix::zeros(parameters, parameters),
    };
    vec![one; blocks]
}

/// The derivative of a number in a lane.
fn part(number: &Dual, lane: usize) -> f64 {
    number.eps.0.as_ref().map_or(0.0, |eps| eps[lane])
}

/// Derivatives of one row.
struct RowDerivatives<'a> {
    row: &'a Innovation<Dual>,
    /// Inverse of the Cholesky factor of S.
    inverse: [[f64; 3]; 3],
    weight: f64,
}

impl<'a> RowDerivatives<'a> {
    fn new(row: &'a Innovation<Dual>) -> Self {
        let mut s = [[0.0; 3]; 3];
        for (s, covariance) in s.iter_mut().zip(&row.covariance) {
            for (s, covariance) in s.iter_mut().zip(covariance) {
                *s = covariance.re;
            }
        }
        for (i, line) in s.iter_mut().enumerate() {
            if line[i] <= 0.0 {
                line[i] = 1.0;
            }
        }
        Self {
            row,
            inverse: inverse_factor(&s),
            weight: (row.weight * row.ordinary).sqrt(),
        }
    }

    /// C⁻¹ ∂ν and C⁻¹ ∂S C⁻ᵀ / √2 by one parameter, with the root of the row's weight; of the symmetric
    /// matrix the lower half, what stands beside the diagonal √2 times.
    fn whitened(&self, lane: usize, scalar: bool) -> [f64; WIDTH] {
        use std::f64::consts::FRAC_1_SQRT_2;
        let (c, row) = (&self.inverse, self.row);
        let mut out = [0.0; WIDTH];
        if scalar {
            let [own, s] = [
                part(&row.difference[0], lane),
                part(&row.covariance[0][0], lane),
            ];
            out[0] = c[0][0] * own * self.weight;
            out[1] = c[0][0] * c[0][0] * s * self.weight * FRAC_1_SQRT_2;
            return out;
        }
        for i in 0..3 {
            out[i] = (0..=i)
                .map(|k| c[i][k] * part(&row.difference[k], lane))
                .sum::<f64>()
                * self.weight;
        }
        let mut place = 3;
        for (i, factor) in c.iter().enumerate() {
            let mut half = [0.0; 3];
            for (l, own) in factor.iter().enumerate().take(i + 1) {
                for (half, covariance) in half.iter_mut().zip(&row.covariance[l]) {
                    *half += own * part(covariance, lane);
                }
            }
            for (k, c) in c.iter().enumerate().take(i + 1) {
                let full: f64 = (0..=k).map(|l| half[l] * c[l]).sum();
                let share = if i == k { FRAC_1_SQRT_2 } else { 1.0 };
                out[place] = full * self.weight * share;
                place += 1;
            }
        }
        out
    }
}
