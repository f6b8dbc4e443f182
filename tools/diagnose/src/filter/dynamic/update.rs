//! Covariance of the state through flow, measurement and disturbances.

use super::derivatives::Derivatives;
use super::{DISTURBANCES, DISTURBED, Matrix, N, Noise, ROLLING};

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

/// Covariance of the first M entries of the state; the others are known.
pub(crate) struct Covariance<const M: usize> {
    pub(crate) p: [[f64; M]; M],
}

impl<const M: usize> Covariance<M> {
    /// Flow, measurement with these variances, and update. Returns the gain of the row.
    pub(crate) fn update(&mut self, step: &Derivatives, variance: &[f64; 3]) -> Gain {
        // P Gᵀ, by rows of Gᵀ
        let mut pg = [[0.0; M]; 3];
        for (own, g) in pg.iter_mut().zip(&step.measurement) {
            for (p, gj) in self.p.iter().zip(g) {
                add(own, *gj, p);
            }
        }
        let mut s = [[0.0; 3]; 3];
        for (a, g) in step.measurement.iter().enumerate() {
            for b in 0..=a {
                let sum: f64 = pg[b].iter().zip(g).map(|(x, y)| x * y).sum();
                s[a][b] = sum;
                s[b][a] = sum;
            }
            s[a][a] += variance[a];
        }
        let (whitening, log_determinant) = whitening(&s);
        // cross covariance of the state after the flow with the row, times the whitening
        let mut cross = pg;
        if !step.still {
            for (own, before) in cross.iter_mut().zip(&pg) {
                for (own, f) in own.iter_mut().zip(&step.flow) {
                    *own = f.iter().zip(before).map(|(x, y)| x * y).sum();
                }
            }
            self.flow(&step.flow);
        }
        let mut w = [[0.0; M]; 3];
        for (own, row) in w.iter_mut().zip(&whitening) {
            for (factor, cross) in row.iter().zip(&cross) {
                add(own, *factor, cross);
            }
        }
        let mut gain = [[0.0; 3]; N];
        for (i, gain) in gain.iter_mut().enumerate().take(M) {
            for (b, own) in gain.iter_mut().enumerate() {
                *own = (b..3).map(|a| w[a][i] * whitening[a][b]).sum();
            }
        }
        let before: [f64; M] = std::array::from_fn(|i| self.p[i][i]);
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

    /// What an update knows better than its digits is known as well as they say, and by itself: where a
    /// wheel begins to slide, or sticks, derivatives over one row may be large.
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

    /// P becomes F P Fᵀ: F (F P)ᵀ, as P is symmetric. F has few entries.
    fn flow(&mut self, f: &Matrix) {
        let once = product(f, &self.p);
        let mut turned = [[0.0; M]; M];
        for (i, row) in once.iter().enumerate() {
            for (k, own) in row.iter().enumerate() {
                turned[k][i] = *own;
            }
        }
        self.p = product(f, &turned);
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
        for (k, a) in decay.iter().enumerate() {
            let j = DISTURBED + k;
            for row in &mut self.p {
                row[j] *= a;
            }
            for own in &mut self.p[j] {
                *own *= a;
            }
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

/// F times `m`, where F has few entries.
fn product<const M: usize>(f: &Matrix, m: &[[f64; M]; M]) -> [[f64; M]; M] {
    let mut out = [[0.0; M]; M];
    for (own, f) in out.iter_mut().zip(f) {
        for (factor, row) in f.iter().zip(m) {
            add(own, *factor, row);
        }
    }
    out
}

/// Inverse of the lower Cholesky factor of `s`, and the log of its determinant.
fn whitening(s: &[[f64; 3]; 3]) -> ([[f64; 3]; 3], f64) {
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
    (inverse, 2.0 * (a.ln() + c.ln() + f.ln()))
}

#[cfg(test)]
mod tests {
    use super::super::{POSE, SLIP};
    use super::*;

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
