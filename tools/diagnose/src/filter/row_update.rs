//! Update of a pose by one row under a scale mixture, merged by moments.
//!
//! With the difference e of a row, factors q and s of a component on process and sensor, and its probability π:
//!
//! ```text
//! P_c = P + (q_c − 1) Q,   S_c = H P_c Hᵀ + s_c R,   K_c = P_c Hᵀ S_c⁻¹
//! x_c = x + K_c e,         P_c⁺ = P_c − K_c H P_c
//! w_c ∝ π_c exp(−½ eᵀ S_c⁻¹ e) / √|2π S_c|
//! x⁺ = Σ w_c x_c,          P⁺ = Σ w_c (P_c⁺ + (x_c − x⁺)(x_c − x⁺)ᵀ)
//! ```

use slipstream_sim::Scalar;

use super::Matrix3;
use super::mixture::{COMPONENTS, NEGLIGIBLE_NATS, PROBABILITY, PROCESS, SENSOR, posterior};

/// log sqrt(2 π).
const LOG_ROOT_TAU: f64 = 0.918_938_533_204_672_7;

/// State and covariance; `q` is what the process added since the last row.
#[derive(Clone)]
pub(crate) struct State<S> {
    pub(crate) mean: [S; 3],
    pub(super) p: Matrix3<S>,
    pub(super) q: Matrix3<S>,
}

/// How the predicted pose of a point moves with that of the axle: H is the identity but for its last column, of which
/// these are the first two entries; rows of what was not seen are zero.
#[derive(Clone, Copy)]
pub(super) struct Lever<S> {
    pub(super) by_heading: [S; 2],
    pub(super) seen: [bool; 3],
}

/// One row: its linearised observation, sensor covariance, and measured minus predicted.
pub(super) struct Row<'a, S> {
    r: &'a Matrix3<S>,
    difference: &'a [S; 3],
    /// H P and H P Hᵀ, H Q and H Q Hᵀ.
    of_state: (Matrix3<S>, Matrix3<S>),
    of_process: (Matrix3<S>, Matrix3<S>),
}

/// What one component makes of the state.
#[derive(Clone, Copy)]
struct Posterior<S> {
    mean: [S; 3],
    p: Matrix3<S>,
}

/// A matrix with these elements.
fn matrix<S>(element: impl Fn(usize, usize) -> S) -> Matrix3<S> {
    std::array::from_fn(|i| std::array::from_fn(|k| element(i, k)))
}

/// A symmetric matrix with these elements on and below its diagonal.
fn symmetric<S: Copy>(element: impl Fn(usize, usize) -> S) -> Matrix3<S> {
    let [a, b, c, d, e, f] =
        [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)].map(|(i, k)| element(i, k));
    [[a, b, d], [b, c, e], [d, e, f]]
}

impl<'a, S: Scalar> Row<'a, S> {
    pub(super) fn new(
        state: &State<S>,
        h: &Lever<S>,
        r: &'a Matrix3<S>,
        difference: &'a [S; 3],
    ) -> Self {
        Self {
            r,
            difference,
            of_state: projected(h, &state.p),
            of_process: projected(h, &state.q),
        }
    }

    /// S_c: covariance of the difference under one component.
    pub(super) fn covariance(&self, component: usize) -> Matrix3<S> {
        let extra = PROCESS[component] - 1.0;
        matrix(|i, k| {
            self.of_state.1[i][k]
                + self.of_process.1[i][k] * extra
                + self.r[i][k] * SENSOR[component]
        })
    }

    /// Log-density of the row under one component, without derivatives.
    fn value(&self, component: usize) -> f64 {
        let extra = PROCESS[component] - 1.0;
        let s = matrix(|i, k| {
            self.of_state.1[i][k].value()
                + self.of_process.1[i][k].value() * extra
                + self.r[i][k].value() * SENSOR[component]
        });
        let d = self.difference.map(|x| x.value());
        log_density(&s, &d).map_or(f64::NEG_INFINITY, |(log, _)| {
            log + PROBABILITY[component].ln()
        })
    }
}

impl<S: Scalar> State<S> {
    /// x⁺ and P⁺: updates with one row under every component and merges them by moments. Returns the
    /// log-likelihood of the row and the probability that it is an ordinary one.
    pub(super) fn merge(&mut self, row: &Row<'_, S>, robust: bool) -> (S, f64) {
        let zero = S::constant(0.0);
        let used = if robust { COMPONENTS } else { 1 };
        let mut values = [f64::NEG_INFINITY; COMPONENTS];
        for (component, value) in values.iter_mut().enumerate().take(used) {
            *value = row.value(component);
        }
        let best = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut each: [Option<Posterior<S>>; COMPONENTS] = [None; COMPONENTS];
        let logs: [Option<S>; COMPONENTS] = std::array::from_fn(|component| {
            let value = values[component];
            if !value.is_finite() || component > 0 && value < best - NEGLIGIBLE_NATS {
                return None;
            }
            let (log, inverse) = log_density(&row.covariance(component), row.difference)?;
            each[component] = Some(self.updated(row, component, &inverse));
            let prior = if robust {
                PROBABILITY[component].ln()
            } else {
                0.0
            };
            Some(log + prior)
        });
        let (weights, log_likelihood) = posterior(&logs);
        let parts = || {
            weights
                .iter()
                .zip(&each)
                .filter_map(|(w, e)| Some((*w, e.as_ref()?)))
        };
        let mean: [S; 3] =
            std::array::from_fn(|i| parts().fold(zero, |sum, (w, own)| sum + w * own.mean[i]));
        let p = symmetric(|i, k| {
            parts().fold(zero, |sum, (w, own)| {
                sum + w * (own.p[i][k] + (own.mean[i] - mean[i]) * (own.mean[k] - mean[k]))
            })
        });
        self.mean = mean;
        self.p = p;
        (log_likelihood, weights[0].value())
    }

    /// x_c and P_c⁺: Kalman update under one component; `inverse` is that of the difference's covariance.
    fn updated(&self, row: &Row<'_, S>, component: usize, inverse: &Matrix3<S>) -> Posterior<S> {
        let zero = S::constant(0.0);
        let extra = PROCESS[component] - 1.0;
        let hp = matrix(|i, k| row.of_state.0[i][k] + row.of_process.0[i][k] * extra);
        let gain = matrix(|i, k| (0..3).fold(zero, |sum, l| sum + hp[l][i] * inverse[l][k]));
        Posterior {
            mean: std::array::from_fn(|i| {
                (0..3).fold(self.mean[i], |sum, k| sum + gain[i][k] * row.difference[k])
            }),
            p: symmetric(|i, k| {
                let prior = self.p[i][k] + self.q[i][k] * extra;
                (0..3).fold(prior, |sum, l| sum - gain[i][l] * hp[l][k])
            }),
        }
    }
}

/// H M and H M Hᵀ.
fn projected<S: Scalar>(h: &Lever<S>, m: &Matrix3<S>) -> (Matrix3<S>, Matrix3<S>) {
    let zero = S::constant(0.0);
    let hm = matrix(|i, k| match (h.seen[i], h.by_heading.get(i)) {
        (false, _) => zero,
        (true, Some(by)) => m[i][k] + *by * m[2][k],
        (true, None) => m[i][k],
    });
    let hmh = symmetric(|i, k| match (h.seen[k], h.by_heading.get(k)) {
        (false, _) => zero,
        (true, Some(by)) => hm[i][k] + *by * hm[i][2],
        (true, None) => hm[i][k],
    });
    (hm, hmh)
}

/// Log of the normal density of `d` with covariance `s`, and the inverse of `s`; `None` where `s` is
/// not positive definite.
fn log_density<S: Scalar>(s: &Matrix3<S>, d: &[S; 3]) -> Option<(S, Matrix3<S>)> {
    let [a, b, c] = s[0];
    let [e, f, i] = [s[1][1], s[1][2], s[2][2]];
    let minor = [e * i - f * f, c * f - b * i, b * f - c * e];
    let determinant = a * minor[0] + b * minor[1] + c * minor[2];
    if determinant.value().partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    let over = S::constant(1.0) / determinant;
    let [p, q, t] = minor.map(|x| x * over);
    let [u, v, w] = [a * i - c * c, b * c - a * f, a * e - b * b].map(|x| x * over);
    let inverse = [[p, q, t], [q, u, v], [t, v, w]];
    let zero = S::constant(0.0);
    let square = (0..3).fold(zero, |sum, i| {
        sum + d[i] * (0..3).fold(zero, |sum, k| sum + inverse[i][k] * d[k])
    });
    let log = (square + determinant.ln()) * -0.5 - 3.0 * LOG_ROOT_TAU;
    Some((log, inverse))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::cholesky::inverse_factor;

    const P: Matrix3<f64> = [[0.3, 0.1, -0.05], [0.1, 0.2, 0.04], [-0.05, 0.04, 0.1]];
    const R: Matrix3<f64> = [[0.02, 0.005, 0.0], [0.005, 0.03, 0.0], [0.0, 0.0, 0.01]];
    const LEVER: Lever<f64> = Lever {
        by_heading: [-0.4, 0.7],
        seen: [true; 3],
    };
    const H: Matrix3<f64> = [[1.0, 0.0, -0.4], [0.0, 1.0, 0.7], [0.0, 0.0, 1.0]];
    const DIFFERENCE: [f64; 3] = [0.1, -0.2, 0.05];

    fn nalgebra(m: &Matrix3<f64>) -> nalgebra::Matrix3<f64> {
        nalgebra::Matrix3::from_fn(|i, k| m[i][k])
    }

    #[test]
    fn the_log_density_is_that_of_the_whitened_difference() {
        let factor = inverse_factor(&P);
        let whitened =
            factor.map(|row| row.iter().zip(DIFFERENCE).map(|(c, d)| c * d).sum::<f64>());
        let square: f64 = whitened.iter().map(|e| e * e).sum();
        let log_root: f64 = (0..3).map(|i| factor[i][i].ln()).sum();
        let (log, inverse) = log_density(&P, &DIFFERENCE).unwrap();
        assert!((log - (log_root - 0.5 * square - 3.0 * LOG_ROOT_TAU)).abs() < 1e-12);
        let one = nalgebra(&inverse) * nalgebra(&P);
        assert!((one - nalgebra::Matrix3::identity()).amax() < 1e-12);
    }

    #[test]
    fn what_is_not_positive_definite_has_no_density() {
        let s = [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(log_density(&s, &DIFFERENCE).is_none());
    }

    #[test]
    fn an_update_adds_the_information_of_the_row() {
        let mut state = State {
            mean: [0.0; 3],
            p: P,
            q: [[0.0; 3]; 3],
        };
        let row = Row::new(&state, &LEVER, &R, &DIFFERENCE);
        let (_, ordinary) = state.merge(&row, false);
        let (h, r) = (nalgebra(&H), nalgebra(&R).try_inverse().unwrap());
        let information = nalgebra(&P).try_inverse().unwrap() + h.transpose() * r * h;
        let p = information.try_inverse().unwrap();
        assert!((nalgebra(&state.p) - p).amax() < 1e-12);
        let mean = p * h.transpose() * r * nalgebra::Vector3::from(DIFFERENCE);
        assert!((mean - nalgebra::Vector3::from(state.mean)).amax() < 1e-12);
        assert_eq!(ordinary, 1.0);
    }
}
