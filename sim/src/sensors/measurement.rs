//! Measurement functions: what the sensors report of a state, without noise, and their time stamps.

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
    /// Time stamp (s) by `stream` of what it measures at the true time `true_s` (s): latency, then
    /// clock drift.
    pub fn stamp_s(&self, stream: Stream, true_s: S) -> S {
        let rate = self.sensing.clock_rate.of(stream);
        (true_s + self.sensing.latency_s.of(stream)) * (rate + 1.0)
    }

    /// True time (s) at which `stream` measured what it stamped `stamp_s` (s): the inverse of
    /// [`Robot::stamp_s`].
    pub fn true_s(&self, stream: Stream, stamp_s: S) -> S {
        let rate = self.sensing.clock_rate.of(stream);
        stamp_s / (rate + 1.0) - self.sensing.latency_s.of(stream)
    }

    /// Age of the content of messages to this robot beyond what their stamps say (s).
    pub fn link_delay_s(&self) -> S {
        self.sensing.link_delay_s
    }

    /// Pose that a camera or motion capture reports for the true `pose` of c: x, y (m) and yaw
    /// (rad, not wrapped).
    pub fn measured_pose(&self, pose: [S; 3]) -> [S; 3] {
        let [forward, left, yaw] = self.sensing.pose_offset;
        let [cos, sin] = heading(pose[2]);
        [
            pose[0] + forward * cos - left * sin,
            pose[1] + forward * sin + left * cos,
            pose[2] + yaw,
        ]
    }

    /// Angles that the encoders report, right and left (rad): with backlash those of the motors;
    /// scaled by the encoder's error.
    pub fn measured_angle(&self, state: &State<S>) -> Pair<S> {
        let at_motors = self.actuator.gap_rad.is_some();
        let [right, left] = if at_motors {
            state.body.motor_angle
        } else {
            state.body.angle
        };
        let scale = self.sensing.encoder_scale;
        [right * scale[0], left * scale[1]]
    }

    /// Speeds of the angles in [`Robot::measured_angle`] (rad/s).
    pub fn measured_speed(&self, state: &State<S>) -> Pair<S> {
        let at_motors = self.actuator.gap_rad.is_some();
        let [right, left] = if at_motors {
            state.body.motor_speed
        } else {
            state.wheel_speed()
        };
        let scale = self.sensing.encoder_scale;
        [right * scale[0], left * scale[1]]
    }

    /// Wheel odometry: forward speed (m/s) and yaw rate (rad/s) from the encoders' `speed` (rad/s)
    /// by the nominal radius and track.
    pub fn odometry(&self, speed: Pair<S>) -> Pair<S> {
        let [r, b] = self.nominal;
        [
            (speed[0] + speed[1]) * (r / 2.0),
            (speed[0] - speed[1]) * (r / (2.0 * b)),
        ]
    }

    /// Specific force along and across the body (m/s²) and yaw rate (rad/s) at c, at the end of the
    /// last step. On a slope it contains gravity, as in a real sensor.
    pub fn measured_inertial(&self, state: &State<S>) -> [S; 3] {
        let [along, across, _] = state.acceleration();
        let [gravity_along, gravity_across] =
            self.slope_gravity.map_or([S::constant(0.0); 2], |[x, y]| {
                let [cos, sin] = heading(state.pose()[2]);
                [x * cos + y * sin, y * cos - x * sin]
            });
        [
            along - gravity_along,
            across - gravity_across,
            state.velocity()[2],
        ]
    }

    /// Encoder counts per revolution of the wheel, if the model gives them.
    pub fn counts_per_rev(&self) -> Option<f64> {
        self.sensing.counts_per_rev
    }
}

/// Counter of an encoder at `angle_rad` (rad) with `phase` in [0, 1): floor(angle · counts / 2π +
/// phase).
pub(crate) fn counts(angle_rad: f64, counts_per_rev: f64, phase: f64) -> i64 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "saturates, after 10^15 turns"
    )]
    let counts = (angle_rad * counts_per_rev / TAU + phase).floor() as i64;
    counts
}
