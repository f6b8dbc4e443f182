//! Score and information of an impulse at every row, by one backward pass (generalised likelihood
//! ratio; Willsky and Jones 1976).

use super::gains::Pass;
use super::update::Gain;
use super::{DISTURBED, N, Vector};

/// An impulse between two rows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Impulse {
    /// When (s).
    pub(crate) t_s: f64,
    /// Along the body (N s) and about the vertical (N m s).
    pub(crate) size: [f64; 2],
    /// Gain in −2 ln L, were the innovations linear in it.
    pub(crate) gain: f64,
}

/// Intervals between rows that are shorter are not looked at (s).
const SHORTEST_S: f64 = 3e-3;

/// Impulses of a force at c, along and across the body, that gain most in each interval. The part
/// across acts as a moment with the lever `com_to_axle_m`. `whitened` and `weights` are those of the
/// rows of the run.
pub(crate) fn impulses(
    pass: &Pass,
    whitened: &[f64],
    weights: &[f64],
    com_to_axle_m: f64,
) -> Vec<Impulse> {
    let mut information = [[0.0; N]; N];
    let mut score = [0.0; N];
    let mut out = Vec::new();
    for (place, row) in pass.rows.iter().enumerate().rev() {
        let at = 3 * row.row;
        let weight = &weights[at..at + 3];
        let e: [f64; 3] = std::array::from_fn(|a| whitened[at + a] * weight[a]);
        let gain = &pass.gains[row.row];
        // −L G, weighted
        let seen: [Vector; 3] = std::array::from_fn(|a| {
            std::array::from_fn(|j| {
                let sum: f64 = (0..=a)
                    .map(|b| gain.whitening[a][b] * row.step.measurement[b][j])
                    .sum();
                -weight[a] * sum
            })
        });
        let after = corrected(gain, row.step.flow, &row.step.measurement, &row.decay);
        let since_s = place
            .checked_sub(1)
            .map_or(row.true_s, |before| pass.rows[before].true_s);
        let over_s = row.true_s - since_s;
        if over_s > SHORTEST_S {
            let column = |k: usize, lever: f64| {
                let mut v: Vector = std::array::from_fn(|i| {
                    if (DISTURBED..DISTURBED + 5).contains(&i) {
                        // the force ends with the interval; what the row corrects stays
                        -lever
                            * row.decay[i - DISTURBED]
                            * correction_of(gain, &row.step.measurement, i, k)
                    } else {
                        lever * after[i][k]
                    }
                });
                if !v.iter().all(|x| x.is_finite()) {
                    v = [0.0; N];
                }
                let own: [f64; 3] = std::array::from_fn(|a| lever * seen[a][k]);
                (v, own)
            };
            let columns = [column(DISTURBED, 1.0), column(DISTURBED + 1, com_to_axle_m)];
            let b = columns.map(|(v, own)| {
                dot(&v, &score) + own.iter().zip(&e).map(|(x, y)| x * y).sum::<f64>()
            });
            let n = |i: usize, k: usize| {
                let (v, own) = &columns[i];
                let (w, other) = &columns[k];
                let far: f64 = (0..N).map(|r| v[r] * dot(&information[r], w)).sum();
                far + own.iter().zip(other).map(|(x, y)| x * y).sum::<f64>()
            };
            let (n00, n01, n11) = (n(0, 0), n(0, 1), n(1, 1));
            let ridge = 1e-9 * (n00 + n11) + 1e-12;
            let (n00, n11) = (n00 + ridge, n11 + ridge);
            let determinant = n00 * n11 - n01 * n01;
            if determinant > 0.0 {
                let x = [
                    -(n11 * b[0] - n01 * b[1]) / determinant,
                    -(n00 * b[1] - n01 * b[0]) / determinant,
                ];
                out.push(Impulse {
                    t_s: since_s + over_s / 2.0,
                    size: x.map(|x| x * over_s),
                    gain: -(x[0] * b[0] + x[1] * b[1]),
                });
            }
        }
        // before this row
        let mut carried = [[0.0; N]; N];
        for (i, line) in carried.iter_mut().enumerate() {
            for (r, after) in after.iter().enumerate() {
                let n = information[i][r];
                if n != 0.0 {
                    for (own, a) in line.iter_mut().zip(after) {
                        *own += n * a;
                    }
                }
            }
        }
        let mut next = [[0.0; N]; N];
        let mut next_score = [0.0; N];
        for (r, after) in after.iter().enumerate() {
            for (i, a) in after.iter().enumerate() {
                if *a != 0.0 {
                    next_score[i] += a * score[r];
                    for (own, c) in next[i].iter_mut().zip(&carried[r]) {
                        *own += a * c;
                    }
                }
            }
        }
        for (seen, e) in seen.iter().zip(&e) {
            for (i, s) in seen.iter().enumerate() {
                next_score[i] += s * e;
                for (own, other) in next[i].iter_mut().zip(seen) {
                    *own += s * other;
                }
            }
        }
        (information, score) = (next, next_score);
    }
    out
}

/// D (F − K G).
fn corrected(
    gain: &Gain,
    flow: super::Matrix,
    measurement: &[[f64; N]; 3],
    decay: &[f64; 5],
) -> super::Matrix {
    let mut out = flow;
    for (i, line) in out.iter_mut().enumerate() {
        for (k, g) in gain.gain[i].iter().zip(measurement) {
            for (own, g) in line.iter_mut().zip(g) {
                *own -= k * g;
            }
        }
        if let Some(a) = i.checked_sub(DISTURBED).and_then(|i| decay.get(i)) {
            for own in line.iter_mut() {
                *own *= a;
            }
        }
    }
    out
}

/// K G of the entry i by the column k.
fn correction_of(gain: &Gain, measurement: &[[f64; N]; 3], i: usize, k: usize) -> f64 {
    (0..3).map(|a| gain.gain[i][a] * measurement[a][k]).sum()
}

fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
