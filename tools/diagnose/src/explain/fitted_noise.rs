//! The noise sizes that were fitted to one run, as an open-loop prediction meets them.

use super::spread::{Rates, Wander};
use crate::filter::ornstein_uhlenbeck::OrnsteinUhlenbeck;
use crate::filter::{gyro, wheels_to_pose};
use crate::model::run::Run;
use crate::model::wheel_parameters::{gyro_parameters, pose_parameters};

/// The noise of one run.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct NoiseOf {
    /// What moves the pose.
    pub(crate) pose: Rates,
    /// Deviations of the pose's sensor: place (m), yaw (rad).
    pub(crate) sensor: [f64; 2],
    /// Variance of its stamps (s²).
    pub(crate) stamp_s2: f64,
    pub(crate) gyro: GyroNoise,
    pub(crate) wheels: WheelNoise,
}

/// Noise of wheels beside the gyro.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GyroNoise {
    yaw_per_m: f64,
    yaw_per_rad: f64,
    yaw_per_s: f64,
    /// Variance of the integrated gyro's rows (rad²), and of its stamps (s²).
    pub(crate) angle: f64,
    pub(crate) stamp_s2: f64,
    /// Disturbance of the turn rate relative to the motion, and its time (s).
    size2: f64,
    time_s: f64,
    /// The turn rate that the drive adds where wheels are simulated from commands.
    drive: Wander,
}

/// Noise of wheels simulated from commands.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct WheelNoise {
    both: [Wander; 2],
    /// Variances of the sensor (rad², or rad²/s²) and of its stamps (s²).
    pub(crate) sensor2: f64,
    stamp_s2: f64,
}

impl NoiseOf {
    /// The noise of a run with these parameters of its own, and with that of its drive where there is one.
    pub(crate) fn new(
        run: &Run,
        local: &[f64],
        drive: Option<&[f64]>,
        turn_per_wheel: f64,
    ) -> Self {
        let pose = pose_parameters(local);
        let p = &pose[wheels_to_pose::PHYSICS..];
        let q = |i: usize| (2.0 * p[i]).exp();
        let wheels = drive.map(WheelNoise::new).unwrap_or_default();
        let rows_per_s = run.pose_series_s().map_or(0.0, f64::recip);
        let seen = f64::from(u8::from(run.pose.is_some()));
        Self {
            pose: Rates {
                along_per_m: q(0),
                across_per_m: q(1),
                yaw_per_m: q(2),
                yaw_per_rad: q(3),
                place_per_s: q(4) * rows_per_s,
                yaw_per_s: q(5) * rows_per_s,
                wheels: wheels.both,
            },
            sensor: [q(6).sqrt() * seen, q(7).sqrt() * seen],
            stamp_s2: q(8),
            gyro: GyroNoise::new(
                &gyro_parameters(local)[gyro::PHYSICS..],
                wheels.both[1],
                turn_per_wheel,
            ),
            wheels,
        }
    }
}

impl GyroNoise {
    fn new(p: &[f64], difference: Wander, turn_per_wheel: f64) -> Self {
        let q = |i: usize| (2.0 * p[i]).exp();
        Self {
            yaw_per_m: q(0),
            yaw_per_rad: q(1),
            yaw_per_s: q(2),
            angle: q(3),
            stamp_s2: q(4),
            size2: q(5),
            time_s: p[6].exp(),
            drive: Wander {
                size_rad_s: difference.size_rad_s * turn_per_wheel,
                time_s: difference.time_s,
                walk: difference.walk * turn_per_wheel,
            },
        }
    }
}

impl WheelNoise {
    fn new(logs: &[f64]) -> Self {
        let size = |i: usize| logs[i].exp();
        let wander = |first: usize| Wander {
            size_rad_s: size(first),
            time_s: size(first + 1),
            walk: size(first + 2),
        };
        Self {
            both: [wander(0), wander(3)],
            sensor2: size(6).powi(2),
            stamp_s2: size(7).powi(2),
        }
    }

    /// Variance of one wheel's angle, or of its speed, so long (s) after the start, turning at this speed
    /// (rad/s).
    pub(crate) fn variance(&self, is_angle: bool, over_s: f64, speed_rad_s: f64) -> f64 {
        let both = self.both.iter();
        if is_angle {
            let wandered: f64 = both.map(|own| own.angle(over_s)).sum();
            wandered + self.stamp_s2 * speed_rad_s * speed_rad_s
        } else {
            both.map(|own| own.size_rad_s * own.size_rad_s).sum()
        }
    }
}

/// Variance of a turn rate and of its integral on their way.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct OfGyro {
    /// Of heading and disturbance.
    p: [f64; 3],
    over_s: f64,
    begun: bool,
    /// Variance of the heading (rad²).
    pub(crate) heading: f64,
}

impl OfGyro {
    /// Moves on by `dt` (s) at this speed (m/s) and turn rate (rad/s); returns the variance of the turn rate.
    pub(crate) fn advance(
        &mut self,
        noise: &GyroNoise,
        half_track_m: f64,
        [speed, turning]: [f64; 2],
        dt: f64,
    ) -> f64 {
        let straight = speed / (2.0 * half_track_m);
        let disturbance = OrnsteinUhlenbeck {
            variance: noise.size2 * gyro::motion2(turning, straight),
            time_s: noise.time_s,
        };
        if !self.begun {
            (self.begun, self.p[2]) = (true, disturbance.variance);
        }
        self.over_s += dt;
        let walk = noise.yaw_per_m * (speed * dt).abs()
            + noise.yaw_per_rad * (turning * dt).abs()
            + noise.yaw_per_s * dt;
        self.p = gyro::carried(&disturbance, &disturbance.step(dt), self.p, walk, dt);
        self.heading = self.p[0] + noise.drive.angle(self.over_s);
        self.p[2] + noise.drive.size_rad_s * noise.drive.size_rad_s
    }
}
