//! Kalman filter from wheel angles to the integrated gyro: a yaw whose errors add up.
//!
//! State: error of the yaw that the wheels predict (rad), and an Ornstein-Uhlenbeck disturbance of
//! the turn rate (rad/s) whose size grows with the turn rate.

use slipstream_sim::Scalar;

use super::Innovation;
use super::mixture::{COMPONENTS, PROBABILITY, PROCESS, SENSOR, posterior};
use super::motion_law::{self, Knots, LAW, OF_TURNS};
use super::ornstein_uhlenbeck::{Integrated, OrnsteinUhlenbeck, Step};
use crate::data::wheel_path::Turned;

/// Physical parameters.
pub(crate) const PHYSICS: usize = FIRST_OF_LAW + LAW - OF_TURNS;
/// The law of turns begins here.
const FIRST_OF_LAW: usize = 6;
/// Logarithms of noise sizes.
pub(crate) const NOISE: usize = 7;
/// log sqrt(2 π).
const LOG_ROOT_TAU: f64 = 0.918_938_533_204_672_7;
/// Share of v/2b in the motion that scales the disturbance, and its least value (rad²/s²).
const STRAIGHT_SHARE: f64 = 0.01;
const LEAST_RATE2: f64 = 1e-6;
/// Least variance of an innovation (rad²).
const LEAST_VARIANCE: f64 = 1e-16;

/// Square of the motion that scales the disturbance (rad²/s²): turn rate, and what driving straight adds.
pub(crate) fn motion2<S: Scalar>(turn_rad_s: S, straight_rad_s: S) -> S {
    turn_rad_s * turn_rad_s + straight_rad_s * straight_rad_s * STRAIGHT_SHARE + LEAST_RATE2
}

/// Covariance of yaw and disturbance after a step of `dt` (s), in which the process adds this variance to the yaw.
pub(crate) fn carried<S: Scalar>(
    disturbance: &OrnsteinUhlenbeck<S>,
    step: &Step<S>,
    cov: [S; 3],
    process: S,
    dt: S,
) -> [S; 3] {
    let [xx, xd, dd] = step.carried(cov);
    let added = disturbance.noise_of_short_step(step, dt);
    [xx + process + added[0], xd + added[1], dd + added[2]]
}

/// One robot's data and nominal geometry.
#[derive(Debug)]
pub(crate) struct Gyro<'a> {
    /// Thinned series of the integrated gyro: stamp (s), angle (rad).
    pub(crate) series: &'a [Vec<(f64, f64)>],
    pub(crate) wheel_radius_m: f64,
    pub(crate) half_track_m: f64,
    /// Knots of the law of turns.
    pub(crate) knots: Knots,
    /// Whether rows may be outliers.
    pub(crate) robust: bool,
}

impl Gyro<'_> {
    /// Filters all series. `parameters`: ln of right and left wheel scale, ln of track scale, latency
    /// (s), clock rate, bias (rad/s), the law of turns; then logs of: yaw per root metre, per root radian, per root
    /// second, angle noise (rad), stamp noise (s), disturbance relative to the motion, its time (s).
    pub(crate) fn run<S: Scalar>(
        &self,
        wheels: &dyn Turned<S>,
        p: &[S],
        sink: &mut dyn FnMut(Innovation<S>),
    ) {
        let weight = 1.0 / self.series.len() as f64;
        let metres_per_rad = [
            p[0].exp() * self.wheel_radius_m,
            p[1].exp() * self.wheel_radius_m,
        ];
        let track_m = p[2].exp() * (2.0 * self.half_track_m);
        let law = &p[FIRST_OF_LAW..PHYSICS];
        let has_law = law.iter().any(|own| own.value() != 0.0);
        let noise = &p[PHYSICS..];
        let q: [S; NOISE] = std::array::from_fn(|i| (noise[i] * 2.0).exp());
        let time_constant_s = noise[6].exp();
        let time = |stamp_s: f64| (S::constant(stamp_s) - p[3]) / (p[4] + 1.0);
        for rows in self.series {
            let Some(first) = rows.first() else { continue };
            let (mut hint, mut last_s) = (0, time(first.0));
            let mut angles = wheels.angles_at(last_s, &mut hint);
            let zero = S::constant(0.0);
            let mut state = Integrated {
                mean: [zero; 2],
                cov: [q[3], zero, zero],
            };
            let mut measured = zero;
            for pair in rows.windows(2) {
                let [before, row] = [pair[0], pair[1]];
                let next_s = time(row.0);
                let dt = next_s - last_s;
                last_s = next_s;
                let next = wheels.angles_at(next_s, &mut hint);
                let turned = [next[0] - angles[0], next[1] - angles[1]];
                angles = next;
                let mut turn =
                    (metres_per_rad[0] * turned[0] - metres_per_rad[1] * turned[1]) / track_m;
                let r = self.wheel_radius_m;
                let way = ((turned[0] + turned[1]) * (r / 2.0)).abs();
                let nominal_turn = (turned[0] - turned[1]) * (r / (2.0 * self.half_track_m));
                let w = nominal_turn / dt;
                if has_law {
                    turn += motion_law::turning(law, w, &self.knots) * dt;
                }
                let straight = way / dt / (2.0 * self.half_track_m);
                let disturbance = OrnsteinUhlenbeck {
                    variance: q[5] * motion2(w, straight),
                    time_s: time_constant_s,
                };
                let process = q[0] * way + q[1] * nominal_turn.abs() + q[2] * dt;
                let step = disturbance.step(dt);
                let cov = carried(&disturbance, &step, state.cov, process, dt);
                state.advance(&step);
                state.cov = cov;
                measured += S::constant(row.1 - before.1) - turn - p[5] * (row.0 - before.0);
                let sensor = q[3] + q[4] * w * w;
                let difference = measured - state.mean[0];
                let (log_likelihood, ordinary, variance) =
                    self.merge(&mut state, difference, sensor, process);
                sink(Innovation {
                    time_s: row.0,
                    weight,
                    scalar: true,
                    ordinary,
                    log_likelihood,
                    difference: [difference, zero, zero],
                    covariance: [[variance, zero, zero], [zero; 3], [zero; 3]],
                });
            }
        }
    }

    /// Updates under every component of the mixture and merges by moments.
    fn merge<S: Scalar>(
        &self,
        state: &mut Integrated<S>,
        difference: S,
        sensor: S,
        process: S,
    ) -> (S, f64, S) {
        let zero = S::constant(0.0);
        let used = if self.robust { COMPONENTS } else { 1 };
        let prior_of = |component: usize| state.cov[0] + process * (PROCESS[component] - 1.0);
        let variance =
            |component: usize| prior_of(component) + sensor * SENSOR[component] + LEAST_VARIANCE;
        let logs: [Option<S>; COMPONENTS] = std::array::from_fn(|component| {
            (component < used).then(|| {
                let s = variance(component);
                let prior = if self.robust {
                    PROBABILITY[component].ln()
                } else {
                    0.0
                };
                (difference * difference / s + s.ln()) * -0.5 - LOG_ROOT_TAU + prior
            })
        });
        let (weights, log_likelihood) = posterior(&logs);
        let each: [Integrated<S>; COMPONENTS] = std::array::from_fn(|component| {
            if component >= used {
                return *state;
            }
            let prior = Integrated {
                cov: [prior_of(component), state.cov[1], state.cov[2]],
                ..*state
            };
            prior.updated(difference, variance(component))
        });
        let ordinary_variance = variance(0);
        let parts = || weights.iter().zip(&each).take(used);
        let mean = [0, 1].map(|i| parts().fold(zero, |sum, (w, own)| sum + *w * own.mean[i]));
        let mut cov = [zero; 3];
        for (weight, own) in parts() {
            let off = [own.mean[0] - mean[0], own.mean[1] - mean[1]];
            cov[0] += *weight * (own.cov[0] + off[0] * off[0]);
            cov[1] += *weight * (own.cov[1] + off[0] * off[1]);
            cov[2] += *weight * (own.cov[2] + off[1] * off[1]);
        }
        *state = Integrated { mean, cov };
        (log_likelihood, weights[0].value(), ordinary_variance)
    }
}
