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

/// What parameters make of a robot and its gyro.
#[derive(Clone)]
pub(crate) struct Model<S> {
    metres_per_rad: [S; 2],
    track_m: S,
    latency_s: S,
    rate: S,
    bias_rad_s: S,
    law: Option<Vec<S>>,
    variance: [S; NOISE],
    time_constant_s: S,
}

impl<S: Scalar> Model<S> {
    /// When a row with this stamp was measured.
    fn time(&self, stamp_s: f64) -> S {
        (S::constant(stamp_s) - self.latency_s) / (self.rate + 1.0)
    }
}

/// A filter on its way.
#[derive(Clone)]
pub(crate) struct On<S> {
    pub(crate) state: Integrated<S>,
    /// When its last row was measured (s), and how far the wheels had turned by then (rad).
    pub(crate) time_s: S,
    pub(crate) angles: [S; 2],
    /// Yaw that was measured minus the one by the wheels (rad).
    pub(crate) measured: S,
    row: (f64, f64),
    hint: usize,
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
        let model = self.model(p);
        for rows in self.series {
            let Some(first) = rows.first() else { continue };
            let mut on = self.begin(wheels, &model, first);
            for row in &rows[1..] {
                let innovation = self.hear(wheels, &model, &mut on, row);
                sink(Innovation {
                    weight,
                    ..innovation
                });
            }
        }
    }

    /// What the parameters make of the robot and its gyro.
    pub(crate) fn model<S: Scalar>(&self, p: &[S]) -> Model<S> {
        let noise = &p[PHYSICS..];
        let law = &p[FIRST_OF_LAW..PHYSICS];
        let has_law = law.iter().any(|own| own.value() != 0.0);
        Model {
            metres_per_rad: [
                p[0].exp() * self.wheel_radius_m,
                p[1].exp() * self.wheel_radius_m,
            ],
            track_m: p[2].exp() * (2.0 * self.half_track_m),
            latency_s: p[3],
            rate: p[4],
            bias_rad_s: p[5],
            law: has_law.then(|| law.to_vec()),
            variance: std::array::from_fn(|i| (noise[i] * 2.0).exp()),
            time_constant_s: noise[6].exp(),
        }
    }

    /// The filter behind the first row of a series.
    pub(crate) fn begin<S: Scalar>(
        &self,
        wheels: &dyn Turned<S>,
        model: &Model<S>,
        first: &(f64, f64),
    ) -> On<S> {
        let (mut hint, time_s, zero) = (0, model.time(first.0), S::constant(0.0));
        let angles = wheels.angles_at(time_s, &mut hint);
        On {
            state: Integrated {
                mean: [zero; 2],
                cov: [model.variance[3], zero, zero],
            },
            time_s,
            measured: zero,
            angles,
            row: *first,
            hint,
        }
    }

    /// Moves on to a row and hears it.
    pub(crate) fn hear<S: Scalar>(
        &self,
        wheels: &dyn Turned<S>,
        model: &Model<S>,
        on: &mut On<S>,
        row: &(f64, f64),
    ) -> Innovation<S> {
        let (q, zero) = (&model.variance, S::constant(0.0));
        let before = std::mem::replace(&mut on.row, *row);
        let next_s = model.time(row.0);
        let dt = next_s - on.time_s;
        on.time_s = next_s;
        let next = wheels.angles_at(next_s, &mut on.hint);
        let turned = [next[0] - on.angles[0], next[1] - on.angles[1]];
        on.angles = next;
        let [right, left] = [0, 1].map(|i| model.metres_per_rad[i] * turned[i]);
        let mut turn = (right - left) / model.track_m;
        let r = self.wheel_radius_m;
        let way = ((turned[0] + turned[1]) * (r / 2.0)).abs();
        let nominal_turn = (turned[0] - turned[1]) * (r / (2.0 * self.half_track_m));
        let w = nominal_turn / dt;
        if let Some(law) = &model.law {
            turn += motion_law::turning(law, w, &self.knots) * dt;
        }
        let straight = way / dt / (2.0 * self.half_track_m);
        let disturbance = OrnsteinUhlenbeck {
            variance: q[5] * motion2(w, straight),
            time_s: model.time_constant_s,
        };
        let process = q[0] * way + q[1] * nominal_turn.abs() + q[2] * dt;
        let step = disturbance.step(dt);
        let cov = carried(&disturbance, &step, on.state.cov, process, dt);
        on.state.advance(&step);
        on.state.cov = cov;
        on.measured += S::constant(row.1 - before.1) - turn - model.bias_rad_s * (row.0 - before.0);
        let sensor = q[3] + q[4] * w * w;
        let difference = on.measured - on.state.mean[0];
        let (log_likelihood, ordinary, variance) =
            self.merge(&mut on.state, difference, sensor, process);
        Innovation {
            time_s: row.0,
            weight: 1.0,
            scalar: true,
            ordinary,
            log_likelihood,
            difference: [difference, zero, zero],
            covariance: [[variance, zero, zero], [zero; 3], [zero; 3]],
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
