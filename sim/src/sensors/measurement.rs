//! What sensors make of a state: exact, without noise. Stamps and true times.

use std::f64::consts::TAU;

use crate::integrate::State;
use crate::parts::parameters::Streams;
use crate::parts::scalar::{Pair, Scalar, heading};
use crate::robot::Robot;

/// A stream of measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// Camera or motion capture.
    Pose,
    /// Encoders.
    Wheels,
    /// Inertial measurement.
    Imu,
}

impl<S: Scalar> Streams<S> {
    fn of(&self, stream: Stream) -> S {
        match stream {
            Stream::Pose => self.pose,
            Stream::Wheels => self.wheels,
            Stream::Imu => self.imu,
        }
    }
}

impl<S: Scalar> Robot<S> {
    /// Stamp (s) that `stream` gives to what it sees at `true_s`: late, by a clock that drifts.
    pub fn stamp_s(&self, stream: Stream, true_s: S) -> S {
        let rate = self.sensing.clock_rate.of(stream);
        (true_s + self.sensing.latency_s.of(stream)) * (rate + 1.0)
    }

    /// When `stream` saw what it stamped `stamp_s` (s): the inverse of [`Robot::stamp_s`].
    pub fn true_s(&self, stream: Stream, stamp_s: S) -> S {
        let rate = self.sensing.clock_rate.of(stream);
        stamp_s / (rate + 1.0) - self.sensing.latency_s.of(stream)
    }

    /// How much older the content of a message to this robot is than its stamp says (s).
    pub fn link_delay_s(&self) -> S {
        self.sensing.link_delay_s
    }

    /// What a camera that tracks the declared point c reports: x, y (m) and yaw (rad, not wrapped).
    pub fn measured_pose(&self, pose: [S; 3]) -> [S; 3] {
        let [forward, left, turn] = self.sensing.pose_offset;
        let [cos, sin] = heading(pose[2]);
        [
            pose[0] + forward * cos - left * sin,
            pose[1] + forward * sin + left * cos,
            pose[2] + turn,
        ]
    }

    /// Angles that the encoders report (rad): of the motors' side of the gears, scaled.
    pub fn measured_angle(&self, state: &State<S>) -> Pair<S> {
        let motors = self.drive.gap_rad.is_some();
        let [right, left] = if motors {
            state.body.motor_angle
        } else {
            state.body.angle
        };
        let scale = self.sensing.encoder_scale;
        [right * scale[0], left * scale[1]]
    }

    /// Speeds of what the encoders count (rad/s).
    pub fn measured_speed(&self, state: &State<S>) -> Pair<S> {
        let motors = self.drive.gap_rad.is_some();
        let [right, left] = if motors {
            state.body.motor_speed
        } else {
            state.wheel_speed()
        };
        let scale = self.sensing.encoder_scale;
        [right * scale[0], left * scale[1]]
    }

    /// Forward speed (m/s) and yaw rate (rad/s) that the robot itself makes of the encoders' speeds
    /// (rad/s), by its nominal radius and track.
    pub fn odometry(&self, speed: Pair<S>) -> Pair<S> {
        let [r, b] = self.nominal;
        [
            (speed[0] + speed[1]) * (r / 2.0),
            (speed[0] - speed[1]) * (r / (2.0 * b)),
        ]
    }

    /// Specific force along and across the body (m/s²) and yaw rate (rad/s) at c. On a slope, weight
    /// shows in it as it does in a real sensor.
    pub fn measured_inertial(&self, state: &State<S>) -> [S; 3] {
        let [along, across, _] = state.acceleration();
        let [pull_along, pull_across] = self.pull.map_or([S::constant(0.0); 2], |[x, y]| {
            let [cos, sin] = heading(state.pose()[2]);
            [x * cos + y * sin, y * cos - x * sin]
        });
        [
            along - pull_along,
            across - pull_across,
            state.velocity()[2],
        ]
    }

    /// Counts in one turn, where the model gives them.
    pub fn counts_per_rev(&self) -> Option<f64> {
        self.sensing.counts_per_rev
    }
}

/// Counter of an encoder at `angle_rad`: floor(angle · counts / 2π + phase).
pub(crate) fn counts(angle_rad: f64, counts_per_rev: f64, phase: f64) -> i64 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "saturates, after 10^15 turns"
    )]
    let counts = (angle_rad * counts_per_rev / TAU + phase).floor() as i64;
    counts
}
