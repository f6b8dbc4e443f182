//! Online friction estimation with a scalar Kalman filter (future work of the paper, section 5).
//!
//! The traction force of a wheel follows from its acceleration: F = (τ − I_wy α) / r. In a turn the
//! wheels also carry the lateral force m_t v w, in proportion to their normal forces. A wheel that
//! accelerates faster than a rolling one could is slipping; its total force divided by N is then a
//! measurement of the friction coefficient. The force of a rolling wheel is a lower bound. While
//! the torque limit is active and no wheel slips, the estimate rises slowly, so that a floor with
//! more friction is noticed.

use crate::geometry::{Dynamics, Geometry};
use crate::traction::rolling_acceleration;
use crate::wheel_torques::WheelTorques;

/// Number of inner ticks over which the acceleration is measured.
const WINDOW: usize = 4;
/// A wheel slips if its excess acceleration is more than this multiple of the largest quantisation
/// error.
const SLIP_THRESHOLD: f64 = 1.25;
/// Standard deviation of the initial estimate, and its upper bound (1).
const INITIAL_SD: f64 = 0.2;
/// Rate at which the estimate rises while the limit is active without slip (1/s).
const RISE_PER_S: f64 = 0.02;
/// Process noise: random walk of the friction coefficient (1/√s).
const RANDOM_WALK_PER_SQRT_S: f64 = 0.005;
/// A measurement of a rolling wheel corrects the estimate if it exceeds the estimate by this many
/// standard deviations.
const LOWER_BOUND_SDS: f64 = 4.0;

/// Estimate of the friction coefficient, its variance, and the last ticks behind it.
#[derive(Debug, Clone)]
pub struct FrictionEstimator {
    friction: f64,
    variance: f64,
    period_s: f64,
    /// Largest acceleration error from encoder quantisation (rad/s²): each of the two speeds of the
    /// window is wrong by less than one count per tick, with a triangular distribution.
    quantisation_rad_s2: f64,
    /// Wheel speeds of the window, the newest last (rad/s).
    speeds: [[f64; 2]; WINDOW + 1],
    /// Torques of the window, the newest last (N m).
    torques: [[f64; 2]; WINDOW + 1],
    /// Whether the limit was active at the last two ticks.
    limited: [bool; 2],
    ticks: usize,
}

impl FrictionEstimator {
    /// Starts at the coefficient `friction` (1), for inner ticks of period `period_s` (s).
    pub fn new(friction: f64, period_s: f64, geometry: &Geometry) -> Self {
        let window_s = period_s * WINDOW as f64;
        Self {
            friction,
            variance: INITIAL_SD * INITIAL_SD,
            period_s,
            quantisation_rad_s2: 2.0 * geometry.count_rad / period_s / window_s,
            speeds: [[0.0; 2]; WINDOW + 1],
            torques: [[0.0; 2]; WINDOW + 1],
            limited: [false; 2],
            ticks: 0,
        }
    }

    /// The estimated friction coefficient (1).
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Its standard deviation (1).
    pub fn standard_deviation(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Updates the estimate with the wheel speeds of an inner tick (rad/s) and the normal forces
    /// (N).
    pub fn update(
        &mut self,
        speed: [f64; 2],
        normal_n: [f64; 2],
        dynamics: &Dynamics,
        geometry: &Geometry,
    ) {
        self.speeds.rotate_left(1);
        self.speeds[WINDOW] = speed;
        self.variance += RANDOM_WALK_PER_SQRT_S * RANDOM_WALK_PER_SQRT_S * self.period_s;
        self.variance = self.variance.min(INITIAL_SD * INITIAL_SD);
        self.ticks += 1;
        if self.ticks <= WINDOW + 1 {
            return;
        }
        let torque = self.mean_torque();
        let window_s = self.period_s * WINDOW as f64;
        let acceleration = [0, 1].map(|i| (speed[i] - self.speeds[0][i]) / window_s);
        let rolling = rolling_acceleration(torque, dynamics, geometry);
        // At the begin of the window the wheels did not slip yet and show the robot's velocity.
        let [v, w] = geometry.twist(self.speeds[0]);
        let lateral = dynamics.m_t * v * w / normal_n.iter().sum::<f64>();
        let mut slips = false;
        for i in 0..2 {
            if normal_n[i] <= 0.0 || torque[i] == 0.0 {
                continue;
            }
            let traction = (torque[i] - dynamics.i_wy * acceleration[i]) / geometry.r;
            let longitudinal = (traction / normal_n[i] * torque[i].signum()).max(0.0);
            let sample = longitudinal.hypot(lateral);
            // The sum of two triangular errors of half the largest error each.
            let acceleration_sd = self.quantisation_rad_s2 / 12f64.sqrt();
            let sample_sd = dynamics.i_wy * acceleration_sd / geometry.r / normal_n[i];
            let excess = (acceleration[i] - rolling[i]) * torque[i].signum();
            let slip = excess > SLIP_THRESHOLD * self.quantisation_rad_s2;
            slips |= slip;
            if slip || sample > self.friction + LOWER_BOUND_SDS * sample_sd {
                self.correct(sample, sample_sd);
            }
        }
        self.rise(slips);
    }

    /// Stores the torques commanded at this tick, and whether the limit is active.
    pub fn store_torques(&mut self, torque: &WheelTorques) {
        self.torques.rotate_left(1);
        self.torques[WINDOW] = torque.torque_nm;
        self.limited = [self.limited[1], torque.torque_nm != torque.wanted_nm];
    }

    /// Mean torque over the window (N m). A measured speed is the mean over its tick, so the window
    /// reaches from the middle of its first tick to the middle of its last.
    fn mean_torque(&self) -> [f64; 2] {
        [0, 1].map(|i| {
            let ends = self.torques[0][i] + self.torques[WINDOW][i];
            let inner: f64 = self.torques[1..WINDOW].iter().map(|torque| torque[i]).sum();
            (inner + 0.5 * ends) / WINDOW as f64
        })
    }

    /// Measurement update of the scalar Kalman filter.
    fn correct(&mut self, sample: f64, sample_sd: f64) {
        let gain = self.variance / (self.variance + sample_sd * sample_sd);
        self.friction += gain * (sample - self.friction);
        self.variance *= 1.0 - gain;
    }

    /// Raises the estimate while the limit is active and no wheel slips.
    fn rise(&mut self, slips: bool) {
        if self.limited == [true; 2] && !slips {
            self.friction += RISE_PER_S * self.period_s;
        }
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;

    /// The estimate of a robot that drives straight on a floor with friction 0.18, with quantised
    /// encoders.
    fn drive(torque_nm: f64, ticks: usize) -> FrictionEstimator {
        let geometry = Geometry::new(&RobotModel::default()).unwrap();
        let dynamics = geometry.dynamics.unwrap();
        let (n, mu, period_s) = (5.06, 0.18, 0.02);
        let mut estimate = FrictionEstimator::new(0.5, period_s, &geometry);
        let rolling = rolling_acceleration([torque_nm; 2], &dynamics, &geometry)[0];
        let roll_force = (torque_nm - dynamics.i_wy * rolling) / geometry.r;
        let force = roll_force.min(mu * n);
        let acceleration = (torque_nm - force * geometry.r) / dynamics.i_wy;
        let mut before = 0;
        for k in 1..=ticks {
            estimate.store_torques(&WheelTorques {
                wanted_nm: [torque_nm; 2],
                torque_nm: [torque_nm; 2],
            });
            let t = k as f64 * period_s;
            let count = (0.5 * acceleration * t * t / geometry.count_rad).floor() as i64;
            let speed = (count - before) as f64 * geometry.count_rad / period_s;
            before = count;
            estimate.update([speed; 2], [n; 2], &dynamics, &geometry);
        }
        estimate
    }

    #[test]
    fn a_slipping_wheel_reveals_the_friction() {
        let estimate = drive(0.13, 25);
        assert!((estimate.friction() - 0.18).abs() < 0.01, "{estimate:?}");
        assert!(estimate.standard_deviation() < 0.01);
        // A quarter of a second suffices.
        assert!((drive(0.13, 12).friction() - 0.18).abs() < 0.02);
    }

    #[test]
    fn a_rolling_wheel_does_not_lower_the_estimate() {
        assert!(drive(0.05, 100).friction() >= 0.5);
    }
}
