//! Sampling of a camera and an inertial sensor at their own rates, with white Gaussian noise.

use slipstream_bus::time::ns_from_s;
use slipstream_bus::{Camera, Imu};

use super::noise::Noise;
use crate::integrate::State;
use crate::robot::Robot;

/// One measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<T> {
    /// Time stamp by the stream's own clock (ns).
    pub stamp_ns: i64,
    /// When the measurement becomes available, in true time (ns).
    pub available_ns: i64,
    /// The measured value.
    pub value: T,
}

/// A sensor with its schedule and its noise.
#[derive(Debug)]
pub(crate) struct Sampler<T> {
    sensor: T,
    noise: Noise,
    period_ns: i64,
    due_ns: i64,
}

impl<T> Sampler<T> {
    fn new(sensor: T, rate_hz: f64, noise: Noise) -> Self {
        let period_ns = ns_from_s(1.0 / rate_hz).max(1);
        Self {
            sensor,
            noise,
            period_ns,
            due_ns: 0,
        }
    }

    /// Whether the sensor samples now: at the first call at or after each multiple of its period.
    fn is_due(&mut self, now_ns: i64) -> bool {
        if now_ns < self.due_ns {
            return false;
        }
        self.due_ns = (now_ns / self.period_ns + 1) * self.period_ns;
        true
    }

    /// Adds noise of the given standard deviations.
    fn add_noise(&mut self, exact: [f64; 3], deviation: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| exact[axis] + self.noise.normal(deviation[axis]))
    }
}

impl Sampler<Camera> {
    pub(crate) fn camera(camera: &Camera, noise: Noise) -> Self {
        Self::new(camera.clone(), camera.rate_hz, noise)
    }

    /// x, y (m) and yaw (rad) of the tracked point; `None` between frames and for a lost frame.
    pub(crate) fn sample(
        &mut self,
        robot: &Robot,
        state: &State,
        stamp_ns: i64,
        now_ns: i64,
    ) -> Option<Sample<[f64; 3]>> {
        if !self.is_due(now_ns) {
            return None;
        }
        let kept = self.noise.uniform() >= self.sensor.dropout;
        let Camera {
            noise_m,
            noise_rad,
            latency_s,
            ..
        } = self.sensor;
        let exact = robot.measured_pose(state.pose());
        // a lost frame draws its noise too: those after it do not depend on the dropout
        let value = self.add_noise(exact, [noise_m, noise_m, noise_rad]);
        kept.then_some(Sample {
            stamp_ns,
            available_ns: now_ns + ns_from_s(latency_s),
            value,
        })
    }
}

impl Sampler<Imu> {
    pub(crate) fn imu(imu: &Imu, noise: Noise) -> Self {
        Self::new(imu.clone(), imu.rate_hz, noise)
    }

    /// Specific force (m/s²) and yaw rate (rad/s); `None` between samples.
    pub(crate) fn sample(
        &mut self,
        robot: &Robot,
        state: &State,
        stamp_ns: i64,
        now_ns: i64,
    ) -> Option<Sample<[f64; 3]>> {
        if !self.is_due(now_ns) {
            return None;
        }
        let Imu {
            noise_m_s2,
            noise_rad_s,
            ..
        } = self.sensor;
        let exact = robot.measured_inertial(state);
        let value = self.add_noise(exact, [noise_m_s2, noise_m_s2, noise_rad_s]);
        Some(Sample {
            stamp_ns,
            available_ns: now_ns,
            value,
        })
    }
}
