//! Sensor models as plain data: external camera and IMU, with rates, noise and latency.

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::range::{FRACTION, NOISE, RATE_HZ, SENSOR_LATENCY_S, within};

/// The sensors of a robot besides its encoders, which the controller reads at every tick.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensors {
    /// An external camera or motion capture.
    pub camera: Option<Camera>,
    /// An inertial sensor at c.
    pub imu: Option<Imu>,
}

/// An external camera or motion capture, which measures the pose of c.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Frames a second (1/s).
    pub rate_hz: f64,
    /// Standard deviation of x and of y (m).
    pub noise_m: f64,
    /// Standard deviation of the yaw (rad).
    pub noise_rad: f64,
    /// From exposure until the pose is available (s). The pose is stamped with the exposure.
    pub latency_s: f64,
    /// Fraction of frames without a pose, 0 to 1 (1).
    pub dropout: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            rate_hz: 30.0,
            noise_m: 0.002,
            noise_rad: 0.009,
            latency_s: 0.0,
            dropout: 0.0,
        }
    }
}

/// An inertial sensor at c: specific force along and across the body, and yaw rate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Imu {
    /// Samples a second (1/s).
    pub rate_hz: f64,
    /// Standard deviation of each specific force (m/s²).
    pub noise_m_s2: f64,
    /// Standard deviation of the yaw rate (rad/s).
    pub noise_rad_s: f64,
}

impl Default for Imu {
    fn default() -> Self {
        Self {
            rate_hz: 100.0,
            noise_m_s2: 0.06,
            noise_rad_s: 0.006,
        }
    }
}

impl Sensors {
    /// Checks all values.
    ///
    /// # Errors
    /// The first value outside the range of its key.
    pub fn validate(&self) -> Result<(), InputError> {
        let mut values = Vec::new();
        if let Some(Camera {
            rate_hz,
            noise_m,
            noise_rad,
            latency_s,
            dropout,
        }) = self.camera
        {
            values.push(("sensors.camera.rate_hz", rate_hz, RATE_HZ));
            values.push(("sensors.camera.noise_m", noise_m, NOISE));
            values.push(("sensors.camera.noise_rad", noise_rad, NOISE));
            values.push(("sensors.camera.latency_s", latency_s, SENSOR_LATENCY_S));
            values.push(("sensors.camera.dropout", dropout, FRACTION));
        }
        if let Some(Imu {
            rate_hz,
            noise_m_s2,
            noise_rad_s,
        }) = self.imu
        {
            values.push(("sensors.imu.rate_hz", rate_hz, RATE_HZ));
            values.push(("sensors.imu.noise_m_s2", noise_m_s2, NOISE));
            values.push(("sensors.imu.noise_rad_s", noise_rad_s, NOISE));
        }
        values
            .into_iter()
            .try_for_each(|(key, value, range)| within(key, value, range))
    }
}
