//! Covariance of the state through flow, measurement and disturbances.
//!
//! With the flow F over a row, the derivatives H of its measurement before the flow, and its variances R:
//!
//! ```text
//! S = H P Hᵀ + R = L Lᵀ,   W = L⁻¹ H P Fᵀ,   K = Wᵀ L⁻¹,   P⁺ = F P Fᵀ − Wᵀ W
//! ```

use super::derivatives::Derivatives;
use super::{ANGLE, DISTURBANCES, DISTURBED, Matrix, N, Noise, POSE, ROLLING, SLIP};

/// Gains and whitening of one row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gain {
    /// K: change of the state per innovation.
    pub(crate) gain: [[f64; 3]; N],
    /// Inverse of the lower Cholesky factor of the innovation's covariance.
    pub(crate) whitening: [[f64; 3]; 3],
    /// Log of the determinant of that covariance.
    pub(crate) log_determinant: f64,
}

impl Gain {
    pub(crate) const NONE: Self = Self {
        gain: [[0.0; 3]; N],
        whitening: [[0.0; 3]; 3],
        log_determinant: 0.0,
    };

    /// K ν.
    pub(crate) fn correction(&self, innovation: &[f64; 3]) -> [f64; N] {
        self.gain
            .map(|row| row[0] * innovation[0] + row[1] * innovation[1] + row[2] * innovation[2])
    }

    /// The innovation, whitened.
    pub(crate) fn whitened(&self, innovation: &[f64; 3]) -> [f64; 3] {
        self.whitening
            .map(|row| row[0] * innovation[0] + row[1] * innovation[1] + row[2] * innovation[2])
    }
}

/// Share of a variance below which an update leaves rounding alone.
const DIGITS: f64 = 1e-12;

/// What a flow changes: pose, motion, wheel angles and slip; disturbances are held.
const MOVED: [usize; 10] = [
    POSE,
    POSE + 1,
    POSE + 2,
    ROLLING,
    ROLLING + 1,
    ANGLE,
    ANGLE + 1,
    SLIP,
    SLIP + 1,
    SLIP + 2,
];
/// What changes it: heading, motion, disturbances and slip. Of place and wheel angles it is the identity.
const MOVING: [usize; 11] = [
    POSE + 2,
    ROLLING,
    ROLLING + 1,
    DISTURBED,
    DISTURBED + 1,
    DISTURBED + 2,
    DISTURBED + 3,
    DISTURBED + 4,
    SLIP,
    SLIP + 1,
    SLIP + 2,
];
/// How many of both are below [`SLIP`].
const MOVED_ROLLING: usize = 7;
const MOVING_ROLLING: usize = 8;

/// Covariance of the first M entries of the state; the others are known.
pub(crate) struct Covariance<const M: usize> {
    pub(crate) p: [[f64; M]; M],
}

impl<const M: usize> Covariance<M> {
    /// Flow, measurement with these variances, and update. Returns the gain of the row.
    pub(crate) fn update(&mut self, step: &Derivatives, variance: &[f64; 3]) -> Gain {
        // H P
        let mut hp = [[0.0; M]; 3];
        for (own, h) in hp.iter_mut().zip(&step.measurement) {
            for (p, h) in self.p.iter().zip(h) {
                add(own, *h, p);
            }
        }
        // S = H P Hᵀ + R
        let mut s = [[0.0; 3]; 3];
        for (a, h) in step.measurement.iter().enumerate() {
            for b in 0..=a {
                let sum: f64 = hp[b].iter().zip(h).map(|(x, y)| x * y).sum();
                s[a][b] = sum;
                s[b][a] = sum;
            }
            s[a][a] += variance[a];
        }
        let (whitening, log_determinant) = whitening(&s);
        // W = L⁻¹ H P Fᵀ
        let mut cross = hp;
        if !step.still {
            cross = hp.map(|before| Self::moved(&step.flow, &before));
            self.flow(&step.flow);
        }
        let mut w = [[0.0; M]; 3];
        for (own, row) in w.iter_mut().zip(&whitening) {
            for (factor, cross) in row.iter().zip(&cross) {
                add(own, *factor, cross);
            }
        }
        // K = Wᵀ L⁻¹
        let mut gain = [[0.0; 3]; N];
        for (i, gain) in gain.iter_mut().enumerate().take(M) {
            for (b, own) in gain.iter_mut().enumerate() {
                *own = (b..3).map(|a| w[a][i] * whitening[a][b]).sum();
            }
        }
        let before: [f64; M] = std::array::from_fn(|i| self.p[i][i]);
        // P⁺ = F P Fᵀ − Wᵀ W
        for (i, row) in self.p.iter_mut().enumerate() {
            for w in &w {
                add(row, -w[i], w);
            }
        }
        self.keep_positive(&before);
        Gain {
            gain,
            whitening,
            log_determinant,
        }
    }

    /// Flow without an update. Returns the variances of the row that would be measured, its sensor's included.
    pub(crate) fn unheard(&mut self, step: &Derivatives, variance: &[f64; 3]) -> [f64; 3] {
        let mut of_row = *variance;
        for (own, g) in of_row.iter_mut().zip(&step.measurement) {
            for (p, gi) in self.p.iter().zip(g) {
                let row: f64 = p.iter().zip(g).map(|(x, y)| x * y).sum();
                *own += gi * row;
            }
        }
        if !step.still {
            self.flow(&step.flow);
        }
        of_row
    }

    /// If rounding leaves a variance below `DIGITS` of the prior, or negative, it is reset to that and decorrelated: where
    /// a wheel begins to slide, or sticks, derivatives over one row may be large.
    fn keep_positive(&mut self, before: &[f64; M]) {
        for (i, before) in before.iter().enumerate() {
            let least = DIGITS * before;
            if self.p[i][i] < least {
                self.p[i] = [0.0; M];
                for row in &mut self.p {
                    row[i] = 0.0;
                }
                self.p[i][i] = least;
            }
        }
    }

    /// Entries of the state that a flow changes, and those that change it.
    fn structure() -> (&'static [usize], &'static [usize]) {
        if M > SLIP {
            (&MOVED, &MOVING)
        } else {
            (&MOVED[..MOVED_ROLLING], &MOVING[..MOVING_ROLLING])
        }
    }

    /// F x; beyond the first M entries x stays.
    pub(super) fn moved<const L: usize>(f: &Matrix, x: &[f64; L]) -> [f64; L] {
        let (moved, moving) = Self::structure();
        let mut out = *x;
        for &i in moved {
            let own = if is_moving(i) { 0.0 } else { x[i] };
            out[i] = own + moving.iter().map(|&k| f[i][k] * x[k]).sum::<f64>();
        }
        out
    }

    /// P becomes F P Fᵀ. What F leaves alone it leaves alone on both sides.
    fn flow(&mut self, f: &Matrix) {
        let (moved, moving) = Self::structure();
        let mut once = [[0.0; M]; M];
        for &i in moved {
            let mut own = if is_moving(i) { [0.0; M] } else { self.p[i] };
            for &k in moving {
                let factor = f[i][k];
                for (own, p) in own.iter_mut().zip(&self.p[k]) {
                    *own += factor * p;
                }
            }
            once[i] = own;
        }
        for &i in moved {
            self.p[i] = once[i];
            for (row, entry) in self.p.iter_mut().zip(&once[i]) {
                row[i] = *entry;
            }
        }
        for (place, &i) in moved.iter().enumerate() {
            for &k in &moved[..=place] {
                let own = if is_moving(k) { 0.0 } else { once[i][k] };
                let entry = own + moving.iter().map(|&j| once[i][j] * f[k][j]).sum::<f64>();
                self.p[i][k] = entry;
                self.p[k][i] = entry;
            }
        }
    }

    /// Standard deviations of the state; 0 for what is known.
    pub(crate) fn deviation(&self) -> [f64; N] {
        let mut out = [0.0; N];
        for (i, own) in out.iter_mut().enumerate().take(M) {
            *own = self.p[i][i].sqrt();
        }
        out
    }

    /// Surge and yaw rate change by as much as these deviations.
    pub(crate) fn push(&mut self, deviation: &[f64; N]) {
        for (i, own) in deviation.iter().enumerate().skip(ROLLING).take(2) {
            self.p[i][i] += own * own;
        }
    }

    /// The disturbances decay, and are disturbed anew.
    pub(crate) fn disturb(&mut self, noise: &Noise, decay: &[f64; DISTURBANCES]) {
        let mut left = [1.0; M];
        left[DISTURBED..DISTURBED + DISTURBANCES].copy_from_slice(decay);
        for (row, own) in self.p.iter_mut().zip(left) {
            for (entry, a) in row.iter_mut().zip(&left) {
                *entry *= own * a;
            }
        }
        for (k, a) in decay.iter().enumerate() {
            let j = DISTURBED + k;
            self.p[j][j] += noise.size[k] * noise.size[k] * (1.0 - a * a);
        }
    }
}

/// Adds `factor` times `from` to `to`.
#[inline]
fn add<const M: usize>(to: &mut [f64; M], factor: f64, from: &[f64; M]) {
    if factor != 0.0 {
        for (own, other) in to.iter_mut().zip(from) {
            *own += factor * other;
        }
    }
}

/// Whether a flow depends on an entry of the state by more than the identity.
fn is_moving(entry: usize) -> bool {
    !(entry < POSE + 2 || (ANGLE..ANGLE + 2).contains(&entry))
}

/// Inverse of the lower Cholesky factor of `s`, and the log of its determinant.
fn whitening(s: &[[f64; 3]; 3]) -> ([[f64; 3]; 3], f64) {
    // the product of three of their roots is not zero
    let least = f64::MIN_POSITIVE.sqrt();
    let a = s[0][0].max(least).sqrt();
    let b = s[1][0] / a;
    let c = (s[1][1] - b * b).max(least).sqrt();
    let d = s[2][0] / a;
    let e = (s[2][1] - d * b) / c;
    let f = (s[2][2] - d * d - e * e).max(least).sqrt();
    let (ia, ic, i_f) = (1.0 / a, 1.0 / c, 1.0 / f);
    let ib = -b * ia * ic;
    let ie = -e * ic * i_f;
    let inverse = [
        [ia, 0.0, 0.0],
        [ib, ic, 0.0],
        [-(d * ia + e * ib) * i_f, ie, i_f],
    ];
    (inverse, 2.0 * (a * c * f).ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// F P Fᵀ in full, for a flow in which everything depends on everything that it may depend on.
    #[test]
    fn a_flow_is_that_of_the_full_matrix() {
        let mut f = [[0.0; N]; N];
        for (i, line) in f.iter_mut().enumerate() {
            line[i] = 1.0;
            if MOVED.contains(&i) {
                for k in MOVING {
                    line[k] += 0.1 * (1.0 + (3 * i + 5 * k) as f64 % 7.0);
                }
            }
        }
        let mut covariance = Covariance::<N> { p: [[0.0; N]; N] };
        for i in 0..N {
            for k in 0..N {
                covariance.p[i][k] = if i == k {
                    5.0
                } else {
                    1.0 / (1 + i + k) as f64
                };
            }
        }
        let before = covariance.p;
        covariance.flow(&f);
        for i in 0..N {
            for k in 0..N {
                let sum = |j: usize| (0..N).map(|l| before[j][l] * f[k][l]).sum::<f64>();
                let full: f64 = (0..N).map(|j| f[i][j] * sum(j)).sum();
                assert!((covariance.p[i][k] - full).abs() < 1e-9, "{i} {k}");
            }
        }
    }

    /// Rows of which each tells two coordinates nearly alike, far better than they were known.
    #[test]
    fn variances_stay_positive_however_much_a_row_says() {
        let mut covariance = Covariance::<SLIP> {
            p: [[0.0; SLIP]; SLIP],
        };
        for i in 0..SLIP {
            covariance.p[i][i] = 1e8;
        }
        let mut flow = [[0.0; N]; N];
        for (i, line) in flow.iter_mut().enumerate() {
            line[i] = 1.0;
        }
        let mut step = Derivatives {
            flow,
            measurement: [[0.0; N]; 3],
            still: true,
        };
        for (k, line) in step.measurement.iter_mut().enumerate() {
            line[POSE] = 1.0;
            line[ROLLING] = 1.0 + 1e-7 * k as f64;
        }
        for _ in 0..5 {
            let gain = covariance.update(&step, &[1e-9; 3]);
            assert!(gain.log_determinant.is_finite());
            assert!((0..SLIP).all(|i| covariance.p[i][i] > 0.0));
        }
    }
}
