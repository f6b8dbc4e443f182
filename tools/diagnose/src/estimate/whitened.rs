//! An innovation divided by its deviation, with what its derivatives need.

use crate::filter::Innovation;
use crate::filter::cholesky::inverse_factor;

/// Most numbers of a row whose squares make the information: 3 of ν, 6 of S.
pub(super) const WIDTH: usize = 9;

/// Deviations from which on an innovation is drawn in: its tails are heavier than those of a normal one, and
/// a copula is about normal scores.
const TAIL: f64 = 2.0;

/// A whitened innovation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Whitened {
    /// Number of its block.
    pub(crate) block: usize,
    /// Weight in the composite likelihood.
    pub(super) weight: f64,
    /// Probability of being ordinary, at most 1.
    pub(super) ordinary: f64,
    /// Root of the weight by which its derivatives were multiplied.
    pub(super) root: f64,
    pub(super) scalar: bool,
    /// The innovation, and its normal score.
    pub(super) raw: [f64; 3],
    pub(super) u: [f64; 3],
}

pub(super) fn dot(x: &[f64; 3], y: &[f64; 3]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// By which factor an innovation of this size is drawn in, and the factor's derivative by the size.
fn winsorised(size: f64) -> [f64; 2] {
    if size <= TAIL {
        return [1.0, 0.0];
    }
    let beyond = 1.0 + size - TAIL;
    let score = TAIL + beyond.ln();
    [score / size, (1.0 / beyond - score / size) / size]
}

impl Whitened {
    /// Of a row with these values.
    pub(crate) fn new(row: &Innovation<f64>, block: usize) -> Self {
        let mut s = row.covariance;
        for (i, line) in s.iter_mut().enumerate() {
            if line[i] <= 0.0 {
                line[i] = 1.0;
            }
        }
        let c = inverse_factor(&s);
        let of = |i: usize| (0..=i).map(|k| c[i][k] * row.difference[k]).sum::<f64>();
        let raw = if row.scalar {
            [c[0][0] * row.difference[0], 0.0, 0.0]
        } else {
            [of(0), of(1), of(2)]
        };
        let [factor, _] = winsorised(dot(&raw, &raw).sqrt());
        Self {
            block,
            weight: row.weight,
            ordinary: row.ordinary.min(1.0),
            root: (row.weight * row.ordinary).sqrt(),
            scalar: row.scalar,
            raw,
            u: raw.map(|own| own * factor),
        }
    }

    /// Numbers that its derivatives have among the whitened ones.
    pub(super) fn width(&self) -> usize {
        if self.scalar { 2 } else { WIDTH }
    }

    /// Derivative of u, and that of the innovation's mean alone, from whitened derivatives.
    pub(super) fn derivatives(&self, whitened: &[f64]) -> [[f64; 3]; 2] {
        use std::f64::consts::FRAC_1_SQRT_2;
        let by = 1.0 / self.root.max(1e-12);
        let (mut full, mut mean) = ([0.0; 3], [0.0; 3]);
        let count = if self.scalar { 1 } else { 3 };
        let mut place = count;
        for i in 0..count {
            mean[i] = whitened[i] * by;
            full[i] = mean[i];
            for (k, raw) in self.raw.iter().enumerate().take(i + 1) {
                let share = if i == k { FRAC_1_SQRT_2 } else { 1.0 };
                full[i] -= share * whitened[place] * by * raw;
                place += 1;
            }
        }
        let size = dot(&self.raw, &self.raw).sqrt();
        let [factor, slope] = winsorised(size);
        let turned = slope * dot(&self.raw, &full) / size.max(f64::MIN_POSITIVE);
        let drawn = std::array::from_fn(|i| factor * full[i] + self.raw[i] * turned);
        [drawn, mean]
    }
}
