//! Sensor models: clocks, offsets, scales and sample times.

use std::f64::consts::{PI, TAU};

use slipstream_bus::{EffectSpec, Parameter};

use super::random::RandomStream;
use slipstream_trial_plant::State;

/// Noise of the camera's position, standard deviation (m).
pub(crate) const POSE_M: f64 = 0.002;
/// Noise of the camera's heading, standard deviation (rad).
pub(crate) const POSE_RAD: f64 = 0.0087;
/// Noise of the accelerometer, standard deviation (m/s²).
pub(crate) const IMU_M_S2: f64 = 0.06;
/// Noise of the gyroscope, standard deviation (rad/s).
pub(crate) const IMU_RAD_S: f64 = 0.006;

/// A stream of measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stream {
    Wheels = 0,
    Pose = 1,
    Imu = 2,
}

/// The sensors of one robot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sensors {
    /// Tracked minus declared point (m), and measured minus true yaw (rad).
    pub(crate) offset: [f64; 3],
    /// Time stamp minus true time of each stream (s).
    pub(crate) latency_s: [f64; 3],
    /// Clock drift of each stream: stamp = t (1 + rate).
    pub(crate) rate: [f64; 3],
    /// Encoder counts per true count, [right, left].
    pub(crate) scale: [f64; 2],
    /// Component of g along the floor, world frame (m/s²).
    pub(crate) gravity: [f64; 2],
}

/// True sample times of each stream (s).
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct SampleTimes(pub(crate) [Vec<f64>; 3]);

impl Sensors {
    /// The sensors with these effects, on a floor of this grade.
    pub(crate) fn new(effects: &[EffectSpec], grade: [f64; 2]) -> Self {
        let steep = grade[0].hypot(grade[1]).atan().cos();
        let mut sensors = Self {
            offset: [0.0; 3],
            latency_s: [0.0; 3],
            rate: [0.0; 3],
            scale: [1.0; 2],
            gravity: grade.map(|grade| grade * steep * slipstream_trial_plant::GRAVITY_M_S2),
        };
        for effect in effects {
            let number = |name: &str| number(effect, name);
            match effect.effect.as_str() {
                "pose_offset" => sensors.offset = ["x_m", "y_m", "yaw_rad"].map(number),
                "pose_latency" => sensors.latency_s[Stream::Pose as usize] = number("latency_s"),
                "wheels_latency" => {
                    sensors.latency_s[Stream::Wheels as usize] = number("latency_s")
                }
                "imu_latency" => sensors.latency_s[Stream::Imu as usize] = number("latency_s"),
                "encoder_scale" => sensors.scale = ["right_scale", "left_scale"].map(number),
                "clock_drift" => sensors.rate[stream(effect) as usize] = number("rate"),
                _ => {}
            }
        }
        sensors
    }

    /// The time stamp of a sample at the true time `true_s` (s).
    pub(crate) fn stamp_s(&self, stream: Stream, true_s: f64) -> f64 {
        (true_s + self.latency_s[stream as usize]) * (1.0 + self.rate[stream as usize])
    }

    /// The true time of a sample with this time stamp (s).
    pub(crate) fn true_s(&self, stream: Stream, stamp_s: f64) -> f64 {
        stamp_s / (1.0 + self.rate[stream as usize]) - self.latency_s[stream as usize]
    }

    /// Wheel angles as measured by the encoders (rad).
    pub(crate) fn angles(&self, state: &State) -> [f64; 2] {
        [0, 1].map(|i| state.motor[i] * self.scale[i])
    }

    /// x, y (m) and yaw (rad, not wrapped) as measured by the camera, without noise.
    pub(crate) fn pose(&self, state: &State) -> [f64; 3] {
        let [x, y, yaw] = state.pose;
        let (sin, cos) = yaw.sin_cos();
        let [forward, left, turn] = self.offset;
        [
            x + forward * cos - left * sin,
            y + forward * sin + left * cos,
            yaw + turn,
        ]
    }

    /// Specific force along and across the body (m/s²) and yaw rate (rad/s), without noise.
    pub(crate) fn inertial(&self, state: &State) -> [f64; 3] {
        let (sin, cos) = state.pose[2].sin_cos();
        let [x, y] = self.gravity;
        let gravity = [x * cos + y * sin, y * cos - x * sin];
        let [along, across] = state.acceleration;
        let yaw_rate = state.velocity[2] + state.carried[2];
        [along - gravity[0], across - gravity[1], yaw_rate]
    }
}

fn number(effect: &EffectSpec, wanted: &str) -> f64 {
    let value = effect.parameters.iter().find(|(name, _)| name == wanted);
    match value {
        Some((_, Parameter::Number(number))) => *number,
        _ => 0.0,
    }
}

fn stream(effect: &EffectSpec) -> Stream {
    let word = effect.parameters.iter().find_map(|(_, value)| match value {
        Parameter::Text(word) => Some(word.as_str()),
        Parameter::Number(_) | Parameter::List(_) => None,
    });
    match word {
        Some("wheels") => Stream::Wheels,
        Some("imu") => Stream::Imu,
        _ => Stream::Pose,
    }
}

/// Draws the sample times: wheels at 50 Hz, camera at about 30 Hz with jitter and dropped frames, inertial
/// sensor at 100 Hz. `present` says which streams exist.
pub(crate) fn sample_times(
    duration_s: f64,
    present: [bool; 3],
    random: &mut RandomStream,
) -> SampleTimes {
    let mut draw = |present: bool, period_s: f64, jitter_s: f64, dropped: f64| {
        let first = random.unit() * period_s;
        let mut times = Vec::new();
        let mut k = 0.0;
        while present && first + k * period_s < duration_s - period_s {
            let t_s = (first + k * period_s + random.normal(jitter_s)).max(0.0);
            if !random.bernoulli(dropped) {
                times.push(super::manoeuvre::rounded(t_s));
            }
            k += 1.0;
        }
        times.sort_by(f64::total_cmp);
        times
    };
    SampleTimes([
        draw(present[0], 0.02, 2e-4, 0.0),
        draw(present[1], 1.0 / 30.0, 2e-3, 0.06),
        draw(present[2], 0.01, 1e-4, 0.0),
    ])
}

/// An angle in (−π, π].
pub(crate) fn wrapped(angle: f64) -> f64 {
    PI - (PI - angle).rem_euclid(TAU)
}

/// Linear interpolation between the states before and after a step, at the time `t_s` (s).
pub(crate) fn interpolate(from: &State, to: &State, t_s: f64) -> State {
    let span = to.t_s - from.t_s;
    let share = if span > 0.0 {
        (t_s - from.t_s) / span
    } else {
        1.0
    };
    let blend = |a: f64, b: f64| a + (b - a) * share;
    let mut state = *to;
    state.t_s = t_s;
    state.pose = std::array::from_fn(|i| blend(from.pose[i], to.pose[i]));
    state.wheel = std::array::from_fn(|i| blend(from.wheel[i], to.wheel[i]));
    state.motor = std::array::from_fn(|i| blend(from.motor[i], to.motor[i]));
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn true_time_inverts_the_stamp() {
        let drift = EffectSpec {
            effect: "clock_drift".to_owned(),
            parameters: vec![
                ("rate".to_owned(), Parameter::Number(1e-3)),
                ("stream".to_owned(), Parameter::Text("wheels".to_owned())),
            ],
        };
        let sensors = Sensors::new(
            &[
                drift,
                EffectSpec::new("wheels_latency", &[("latency_s", 0.02)]),
            ],
            [0.0; 2],
        );
        assert!((sensors.stamp_s(Stream::Wheels, 10.0) - 10.030_02).abs() < 1e-12);
        assert!((sensors.true_s(Stream::Wheels, 10.030_02) - 10.0).abs() < 1e-12);
        assert_eq!(sensors.stamp_s(Stream::Pose, 3.0), 3.0);
    }

    #[test]
    fn angles_wrap() {
        assert!((wrapped(3.5 * PI) + PI / 2.0).abs() < 1e-12);
        assert!((wrapped(PI) - PI).abs() < 1e-12);
        assert!((wrapped(-0.1) + 0.1).abs() < 1e-12);
    }
}
