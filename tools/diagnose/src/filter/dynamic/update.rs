//! Covariance of the state through flow, measurement and disturbances.

use super::{DISTURBANCES, DISTURBED, Matrix, N, Noise};

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

/// Derivatives of flow and measurement from one row to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Derivatives {
    /// State after the flow, by the state before it.
    pub(crate) flow: Matrix,
    /// What is measured, by the state before the flow.
    pub(crate) measurement: [[f64; N]; 3],
}

/// Covariance of the state; only the first `used` entries are not zero.
pub(crate) struct Covariance {
    pub(crate) p: Matrix,
    pub(crate) used: usize,
}

impl Covariance {
    /// Flow, measurement with these variances, and update. Returns the gain of the row.
    pub(crate) fn update(&mut self, step: &Derivatives, variance: &[f64; 3]) -> Gain {
        let n = self.used;
        // P Gᵀ
        let mut pg = [[0.0; 3]; N];
        for (a, g) in step.measurement.iter().enumerate() {
            for (j, gj) in g.iter().enumerate().take(n) {
                if *gj != 0.0 {
                    for i in 0..n {
                        pg[i][a] += self.p[j][i] * gj;
                    }
                }
            }
        }
        let mut s = [[0.0; 3]; 3];
        for (a, g) in step.measurement.iter().enumerate() {
            for b in 0..=a {
                let sum: f64 = (0..n).map(|i| g[i] * pg[i][b]).sum();
                s[a][b] = sum;
                s[b][a] = sum;
            }
            s[a][a] += variance[a];
        }
        let (whitening, log_determinant) = whitening(&s);
        // cross covariance of the state after the flow with the row, times the whitening
        let mut w = [[0.0; 3]; N];
        for i in 0..n {
            let mut cross = [0.0; 3];
            for j in 0..n {
                let f = step.flow[i][j];
                if f != 0.0 {
                    for a in 0..3 {
                        cross[a] += f * pg[j][a];
                    }
                }
            }
            for a in 0..3 {
                w[i][a] = (0..=a).map(|b| whitening[a][b] * cross[b]).sum();
            }
        }
        self.flow(&step.flow);
        let mut gain = [[0.0; 3]; N];
        for i in 0..n {
            for b in 0..3 {
                gain[i][b] = (b..3).map(|a| w[i][a] * whitening[a][b]).sum();
            }
            let [x, y, z] = w[i];
            let row = &mut self.p[i];
            for (j, other) in w.iter().enumerate().take(n) {
                row[j] -= x * other[0] + y * other[1] + z * other[2];
            }
        }
        Gain {
            gain,
            whitening,
            log_determinant,
        }
    }

    /// P becomes F P Fᵀ.
    fn flow(&mut self, f: &Matrix) {
        let n = self.used;
        let mut fp = [[0.0; N]; N];
        for i in 0..n {
            let row = &mut fp[i];
            for (k, fk) in f[i].iter().enumerate().take(n) {
                if *fk != 0.0 {
                    for (own, p) in row.iter_mut().zip(&self.p[k]) {
                        *own += fk * p;
                    }
                }
            }
        }
        // fp Fᵀ: its i-th row is the combination of columns; by symmetry only rows j <= i
        for i in 0..n {
            for j in 0..=i {
                let sum: f64 = (0..n).map(|k| fp[i][k] * f[j][k]).sum();
                self.p[i][j] = sum;
                self.p[j][i] = sum;
            }
        }
    }

    /// The disturbances decay, and are disturbed anew.
    pub(crate) fn disturb(&mut self, noise: &Noise, decay: &[f64; DISTURBANCES]) {
        for (k, a) in decay.iter().enumerate() {
            let j = DISTURBED + k;
            for i in 0..self.used {
                self.p[i][j] *= a;
                self.p[j][i] *= a;
            }
            self.p[j][j] += noise.size[k] * noise.size[k] * (1.0 - a * a);
        }
    }
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
