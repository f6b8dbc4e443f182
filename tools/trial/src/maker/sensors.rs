//! What sensors make of the truth: clocks, offsets, scales, and when they look.

use std::f64::consts::{PI, TAU};

use slipstream_bus::{EffectSpec, Parameter};

use super::chance::Chance;
use crate::plant::State;

/// White noise of camera (m, rad) and inertial sensor (m/s², rad/s).
pub(crate) const POSE_M: f64 = 0.002;
pub(crate) const POSE_RAD: f64 = 0.0087;
pub(crate) const IMU_M_S2: f64 = 0.06;
pub(crate) const IMU_RAD_S: f64 = 0.006;

/// A stream of measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stream {
    Wheels = 0,
    Pose = 1,
    Imu = 2,
}

/// How sensors see one robot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sensors {
    /// Really tracked point minus declared point (m), and measured minus true yaw (rad).
    pub(crate) offset: [f64; 3],
    /// Stamp minus true time, by stream (s).
    pub(crate) latency_s: [f64; 3],
    /// Stamp = t (1 + rate), by stream.
    pub(crate) rate: [f64; 3],
    /// Counts for each true count, [right, left].
    pub(crate) scale: [f64; 2],
    /// Horizontal part of g, world frame (m/s²).
    pub(crate) pull: [f64; 2],
}

/// When each stream looked: the true instants (s).
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Looks(pub(crate) [Vec<f64>; 3]);

impl Sensors {
    /// The sensors that `effects` describe.
    pub(crate) fn new(effects: &[EffectSpec], grade: [f64; 2]) -> Self {
        let steep = grade[0].hypot(grade[1]).atan().cos();
        let mut sensors = Self {
            offset: [0.0; 3],
            latency_s: [0.0; 3],
            rate: [0.0; 3],
            scale: [1.0; 2],
            pull: grade.map(|grade| grade * steep * crate::plant::GRAVITY_M_S2),
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

    /// The stamp of what `stream` saw at `true_s`.
    pub(crate) fn stamp_s(&self, stream: Stream, true_s: f64) -> f64 {
        (true_s + self.latency_s[stream as usize]) * (1.0 + self.rate[stream as usize])
    }

    /// When `stream` saw what it stamped so.
    pub(crate) fn true_s(&self, stream: Stream, stamp_s: f64) -> f64 {
        stamp_s / (1.0 + self.rate[stream as usize]) - self.latency_s[stream as usize]
    }

    /// Angles as the encoders count them (rad).
    pub(crate) fn angles(&self, state: &State) -> [f64; 2] {
        [0, 1].map(|i| state.motor[i] * self.scale[i])
    }

    /// x, y (m) and yaw (rad, not wrapped) as the camera sees them.
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

    /// Specific force along and across the body (m/s²) and yaw rate (rad/s).
    pub(crate) fn inertial(&self, state: &State) -> [f64; 3] {
        let (sin, cos) = state.pose[2].sin_cos();
        let [x, y] = self.pull;
        let pull = [x * cos + y * sin, y * cos - x * sin];
        let [along, across] = state.acceleration;
        [along - pull[0], across - pull[1], state.velocity[2]]
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
        Parameter::Number(_) => None,
    });
    match word {
        Some("wheels") => Stream::Wheels,
        Some("imu") => Stream::Imu,
        _ => Stream::Pose,
    }
}

/// Draws when each stream looks: wheels at 50 Hz, the camera at about 30 Hz with jitter and dropped
/// frames, the inertial sensor at 100 Hz. A stream that is not there never looks.
pub(crate) fn looks(duration_s: f64, there: [bool; 3], chance: &mut Chance) -> Looks {
    let mut draw = |there: bool, period_s: f64, jitter_s: f64, dropped: f64| {
        let first = chance.unit() * period_s;
        let mut times = Vec::new();
        let mut k = 0.0;
        while there && first + k * period_s < duration_s - period_s {
            let t_s = (first + k * period_s + chance.normal(jitter_s)).max(0.0);
            if !chance.happens(dropped) {
                times.push(super::manoeuvre::rounded(t_s));
            }
            k += 1.0;
        }
        times.sort_by(f64::total_cmp);
        times
    };
    Looks([
        draw(there[0], 0.02, 2e-4, 0.0),
        draw(there[1], 1.0 / 30.0, 2e-3, 0.06),
        draw(there[2], 0.01, 1e-4, 0.0),
    ])
}

/// An angle in (−π, π].
pub(crate) fn wrapped(angle: f64) -> f64 {
    PI - (PI - angle).rem_euclid(TAU)
}

/// What lies between two states of one step, at a share of it.
pub(crate) fn between(from: &State, to: &State, t_s: f64) -> State {
    let span = to.t_s - from.t_s;
    let share = if span > 0.0 {
        (t_s - from.t_s) / span
    } else {
        1.0
    };
    let mix = |a: f64, b: f64| a + (b - a) * share;
    let mut state = *to;
    state.t_s = t_s;
    state.pose = std::array::from_fn(|i| mix(from.pose[i], to.pose[i]));
    state.wheel = std::array::from_fn(|i| mix(from.wheel[i], to.wheel[i]));
    state.motor = std::array::from_fn(|i| mix(from.motor[i], to.motor[i]));
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_go_both_ways() {
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
