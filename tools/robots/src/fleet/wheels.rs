//! What the wheels of a real robot have turned, as counts of encoders for its agent.

use std::f64::consts::TAU;

use slipstream_bus::message::Encoders;
use slipstream_bus::{Encoder, RobotModel};
use slipstream_recording::wrapped;

/// Turn of a wheel between two messages beyond what its speed allows (rad) that still counts as a turn.
const SLACK_RAD: f64 = 0.5;

/// The wheels of one robot. Pairs are [right, left].
#[derive(Debug, Clone)]
pub(super) struct Wheels {
    r: f64,
    b: f64,
    counts_per_rad: f64,
    /// Speed beyond which an angle has jumped (rad/s).
    fastest_rad_s: f64,
    /// The last angles as the robot said them, and when (ns).
    last: Option<([f64; 2], i64)>,
    /// The last pose by odometry.
    last_pose: Option<[f64; 3]>,
    /// What the wheels have turned since the first message (rad).
    turned_rad: [f64; 2],
    /// The counts at the start of the run.
    base: [i64; 2],
    /// Number of jumps.
    pub(super) jumps: u64,
    /// Speed of a wheel at the robot's limits (rad/s).
    limit_rad_s: f64,
    /// Whether a wheel was faster than [`OVERSPEED`] times that, over [`OVERSPEED_NS`] at least.
    pub(super) was_too_fast: bool,
    /// Where that is measured from: angles turned (rad) and when (ns).
    measured_from: Option<([f64; 2], i64)>,
}

/// How much faster than at its limits a wheel may turn: loops of speed overshoot.
const OVERSPEED: f64 = 1.5;
/// Time over which a speed is measured at least (ns): stamps of single messages scatter.
const OVERSPEED_NS: i64 = 50_000_000;

impl Wheels {
    /// The wheels of a robot that is told at most `fastest_rad_s`.
    pub(super) fn new(model: &RobotModel, fastest_rad_s: f64) -> Self {
        let encoder = model.encoder.as_ref().unwrap_or(&Encoder::MICRORADIANS);
        Self {
            r: model.robot.wheel_radius_m,
            b: model.robot.half_track_m,
            counts_per_rad: encoder.counts_per_rev / TAU,
            // A robot that slips or is pushed may be faster than it is told.
            fastest_rad_s: 4.0 * fastest_rad_s,
            last: None,
            last_pose: None,
            turned_rad: [0.0; 2],
            base: [0; 2],
            jumps: 0,
            limit_rad_s: fastest_rad_s,
            was_too_fast: false,
            measured_from: None,
        }
    }

    /// Takes angles (rad). Angles that wrap, or restart at another value, are joined to those before.
    pub(super) fn take_angles(&mut self, angle_rad: [f64; 2], t_ns: i64) {
        let (last, last_ns) = self.last.unwrap_or((angle_rad, t_ns));
        let dt_s = (t_ns - last_ns).max(0) as f64 * 1e-9;
        for side in 0..2 {
            let mut turned = angle_rad[side] - last[side];
            if turned.abs() > self.fastest_rad_s * dt_s + SLACK_RAD {
                turned = wrapped(turned);
                self.jumps += 1;
            }
            self.turned_rad[side] += turned;
        }
        self.last = Some((angle_rad, t_ns));
        self.measure_speed(t_ns);
    }

    fn measure_speed(&mut self, t_ns: i64) {
        let (from_rad, from_ns) = *self.measured_from.get_or_insert((self.turned_rad, t_ns));
        let elapsed_ns = t_ns - from_ns;
        if elapsed_ns >= OVERSPEED_NS {
            let largest_rad = OVERSPEED * self.limit_rad_s * elapsed_ns as f64 * 1e-9;
            let sides = self.turned_rad.iter().zip(from_rad);
            self.was_too_fast |= sides
                .map(|(now, from)| (now - from).abs())
                .any(|own| own > largest_rad);
            self.measured_from = Some((self.turned_rad, t_ns));
        }
    }

    /// Takes the pose of an odometry: what the wheels have turned by the model since the last one.
    pub(super) fn take_pose(&mut self, pose: [f64; 3], t_ns: i64) {
        let [x, y, yaw] = pose;
        let [last_x, last_y, last_yaw] = self.last_pose.replace(pose).unwrap_or(pose);
        let turn = wrapped(yaw - last_yaw);
        let (sin, cos) = (last_yaw + turn / 2.0).sin_cos();
        let driven = (x - last_x) * cos + (y - last_y) * sin;
        self.turned_rad[0] += (driven + self.b * turn) / self.r;
        self.turned_rad[1] += (driven - self.b * turn) / self.r;
        self.measure_speed(t_ns);
    }

    /// From now on counts begin at 0. What the wheels did before, moved by hand perhaps, is no speed of a run.
    pub(super) fn begin(&mut self) {
        (self.was_too_fast, self.measured_from) = (false, None);
        self.base = [0; 2];
        self.base = self.counts();
    }

    /// The encoders as of a message that was stamped at `sampled_ns`.
    pub(super) fn encoders(&self, sampled_ns: i64) -> Encoders {
        let counts = self.counts();
        Encoders { sampled_ns, counts }
    }

    fn counts(&self) -> [i64; 2] {
        [0, 1].map(|side| {
            let counts = (self.turned_rad[side] * self.counts_per_rad).floor();
            counts as i64 - self.base[side]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wheels() -> Wheels {
        Wheels::new(&RobotModel::default(), 20.0)
    }

    #[test]
    fn angles_that_wrap_are_joined() {
        let mut wheels = wheels();
        for k in 0..200_i64 {
            let angle = 0.1 * k as f64 + 1e-9;
            wheels.take_angles([angle, -wrapped(angle)], k * 20_000_000);
        }
        let counts = wheels.encoders(0).counts;
        let expected = (19.9 * 1856.0 / TAU) as i64;
        assert!(
            (counts[0] - expected).abs() <= 1 && (counts[1] + expected).abs() <= 1,
            "{counts:?}"
        );
        assert_eq!(wheels.jumps, 3);
    }

    #[test]
    fn a_pause_of_a_cumulative_angle_is_no_jump() {
        let mut wheels = wheels();
        wheels.take_angles([0.0; 2], 0);
        wheels.take_angles([30.0; 2], 2_000_000_000);
        assert_eq!(
            (wheels.jumps, wheels.encoders(0).counts[0]),
            (0, (30.0 * 1856.0 / TAU) as i64)
        );
    }

    #[test]
    fn a_wheel_that_is_too_fast_is_noticed_and_one_that_overshoots_is_not() {
        let turns_at = |rad_s: f64| {
            let mut wheels = wheels();
            for k in 0..50_i64 {
                wheels.take_angles([rad_s * 0.02 * k as f64, 0.0], k * 20_000_000);
            }
            wheels.was_too_fast
        };
        assert!(!turns_at(-25.0));
        assert!(turns_at(-31.0));
    }

    #[test]
    fn odometry_on_an_arc_gives_the_turns_of_the_wheels() {
        let mut wheels = wheels();
        let (r, b, radius) = (0.0365, 0.105, 1.0);
        for k in 0..=1000 {
            let yaw = 4.0 * f64::from(k) / 1000.0;
            let pose = [radius * yaw.sin(), radius * (1.0 - yaw.cos()), wrapped(yaw)];
            wheels.take_pose(pose, i64::from(k) * 20_000_000);
        }
        let expected = [(radius + b) * 4.0 / r, (radius - b) * 4.0 / r];
        for (turned, expected) in wheels.turned_rad.iter().zip(expected) {
            assert!((turned - expected).abs() < 1e-3, "{turned} {expected}");
        }
        wheels.begin();
        assert_eq!(
            wheels.encoders(7),
            Encoders {
                sampled_ns: 7,
                counts: [0; 2]
            }
        );
    }
}
