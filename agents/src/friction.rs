//! Friction between wheel and floor, estimated while driving (the paper's future work).
//!
//! The traction at a wheel follows from its own acceleration: F = (τ − I_wy α) / r, whatever the
//! robot does; in a turn the wheels also carry m_t v w across the axle, each by its normal force. A
//! wheel that accelerates faster than the rolling robot could is slipping, and then both forces
//! together over N are the friction; of a rolling wheel they are a lower bound. While the limit is in force
//! and nothing slips the estimate rises slowly, so that a better floor is found again.

use crate::geometry::{Dynamics, Geometry};
use crate::traction::rolling_acceleration;
use crate::wheels::WheelTorque;

/// Inner ticks over which an acceleration is measured.
const WINDOW: usize = 4;
/// A wheel slips when its excess acceleration is beyond this much of what the encoders' grain can
/// feign.
const SURE: f64 = 1.25;
/// Standard deviation of the estimate before anything was felt (1).
const FIRST_SD: f64 = 0.2;
/// How fast the estimate rises while the limit is in force without slip (1/s).
const PROBE_PER_S: f64 = 0.02;
/// How fast certainty fades (1/√s).
const FADE_PER_SQRT_S: f64 = 0.005;

/// The estimate, its certainty, and the last ticks behind it.
#[derive(Debug, Clone)]
pub struct FrictionEstimate {
    friction: f64,
    variance: f64,
    period_s: f64,
    /// The most that the encoders' grain can feign over the window (rad/s²): each of the two speeds
    /// is off by less than one count in its tick, with a triangular distribution.
    grain_rad_s2: f64,
    speeds: [[f64; 2]; WINDOW + 1],
    torques: [[f64; 2]; WINDOW + 1],
    /// Whether the limit was in force at the last two ticks.
    limited: [bool; 2],
    ticks: usize,
}

impl FrictionEstimate {
    /// Begins at `friction` (1) for inner ticks of `period_s`.
    pub fn new(friction: f64, period_s: f64, geometry: &Geometry) -> Self {
        let window_s = period_s * WINDOW as f64;
        Self {
            friction,
            variance: FIRST_SD * FIRST_SD,
            period_s,
            grain_rad_s2: 2.0 * geometry.count_rad / period_s / window_s,
            speeds: [[0.0; 2]; WINDOW + 1],
            torques: [[0.0; 2]; WINDOW + 1],
            limited: [false; 2],
            ticks: 0,
        }
    }

    /// The estimate (1).
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Its standard deviation (1).
    pub fn standard_deviation(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Takes in the wheel speeds of an inner tick (rad/s), under the normal forces (N).
    pub fn feel(
        &mut self,
        speed: [f64; 2],
        normal_n: [f64; 2],
        dynamics: &Dynamics,
        geometry: &Geometry,
    ) {
        self.speeds.rotate_left(1);
        self.speeds[WINDOW] = speed;
        self.variance += FADE_PER_SQRT_S * FADE_PER_SQRT_S * self.period_s;
        self.variance = self.variance.min(FIRST_SD * FIRST_SD);
        self.ticks += 1;
        if self.ticks <= WINDOW + 1 {
            return;
        }
        let torque = self.mean_torque();
        let window_s = self.period_s * WINDOW as f64;
        let acceleration = [0, 1].map(|i| (speed[i] - self.speeds[0][i]) / window_s);
        let rolling = rolling_acceleration(torque, dynamics, geometry);
        // Before the wheels began to slip they told the robot's own speeds.
        let [v, w] = geometry.twist(self.speeds[0]);
        let across = dynamics.m_t * v * w / normal_n.iter().sum::<f64>();
        let mut slips = false;
        for i in 0..2 {
            if normal_n[i] <= 0.0 || torque[i] == 0.0 {
                continue;
            }
            let traction = (torque[i] - dynamics.i_wy * acceleration[i]) / geometry.r;
            let along = (traction / normal_n[i] * torque[i].signum()).max(0.0);
            let sample = along.hypot(across);
            // Two triangular errors of half the grain each: grain / √12.
            let acceleration_sd = self.grain_rad_s2 / 12f64.sqrt();
            let sample_sd = dynamics.i_wy * acceleration_sd / geometry.r / normal_n[i];
            let excess = (acceleration[i] - rolling[i]) * torque[i].signum();
            let slip = excess > SURE * self.grain_rad_s2;
            slips |= slip;
            if slip || sample > self.friction + 4.0 * sample_sd {
                self.correct(sample, sample_sd);
            }
        }
        self.probe(slips);
    }

    /// Remembers the torques applied from this tick on, and whether more was wanted.
    pub fn applied(&mut self, torque: &WheelTorque) {
        self.torques.rotate_left(1);
        self.torques[WINDOW] = torque.torque_nm;
        self.limited = [self.limited[1], torque.torque_nm != torque.wanted_nm];
    }

    /// Mean torque over the window. A measured speed is the mean over its tick, so that the window
    /// reaches from the middle of its first tick to the middle of its last.
    fn mean_torque(&self) -> [f64; 2] {
        [0, 1].map(|i| {
            let ends = self.torques[0][i] + self.torques[WINDOW][i];
            let inner: f64 = self.torques[1..WINDOW].iter().map(|torque| torque[i]).sum();
            (inner + 0.5 * ends) / WINDOW as f64
        })
    }

    /// One measurement of a constant with a known standard deviation (Kalman filter).
    fn correct(&mut self, sample: f64, sample_sd: f64) {
        let gain = self.variance / (self.variance + sample_sd * sample_sd);
        self.friction += gain * (sample - self.friction);
        self.variance *= 1.0 - gain;
    }

    fn probe(&mut self, slips: bool) {
        if self.limited == [true; 2] && !slips {
            self.friction += PROBE_PER_S * self.period_s;
        }
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;

    /// A robot that drives straight on a floor of friction 0.18, with quantised encoders.
    fn drive(torque_nm: f64, ticks: usize) -> FrictionEstimate {
        let geometry = Geometry::new(&RobotModel::default()).unwrap();
        let dynamics = geometry.dynamics.unwrap();
        let (n, mu, period_s) = (5.06, 0.18, 0.02);
        let mut estimate = FrictionEstimate::new(0.5, period_s, &geometry);
        let rolling = rolling_acceleration([torque_nm; 2], &dynamics, &geometry)[0];
        let roll_force = (torque_nm - dynamics.i_wy * rolling) / geometry.r;
        let force = roll_force.min(mu * n);
        let acceleration = (torque_nm - force * geometry.r) / dynamics.i_wy;
        let mut before = 0;
        for k in 1..=ticks {
            estimate.applied(&WheelTorque {
                wanted_nm: [torque_nm; 2],
                torque_nm: [torque_nm; 2],
            });
            let t = k as f64 * period_s;
            let count = (0.5 * acceleration * t * t / geometry.count_rad).floor() as i64;
            let speed = (count - before) as f64 * geometry.count_rad / period_s;
            before = count;
            estimate.feel([speed; 2], [n; 2], &dynamics, &geometry);
        }
        estimate
    }

    #[test]
    fn a_slipping_wheel_tells_the_friction() {
        let estimate = drive(0.13, 25);
        assert!((estimate.friction() - 0.18).abs() < 0.01, "{estimate:?}");
        assert!(estimate.standard_deviation() < 0.01);
        // It knew within a quarter of a second.
        assert!((drive(0.13, 12).friction() - 0.18).abs() < 0.02);
    }

    #[test]
    fn a_rolling_wheel_does_not_lower_the_estimate() {
        assert!(drive(0.05, 100).friction() >= 0.5);
    }
}
