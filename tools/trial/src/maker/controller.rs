//! A robot's controller: Kanayama's tracking law at 20 Hz on encoder odometry, PI wheel loops at 50 Hz.

use super::manoeuvre::COMMAND_PERIOD_S;
use super::reference::Reference;

/// Gains of Kanayama's law: k_x (1/s), k_y (1/m²), k_θ (1/m).
const TRACKING_GAINS: [f64; 3] = [1.0, 12.0, 4.0];
/// Gains of the PI wheel loops: k_p (N m s/rad) and k_i (N m/rad).
const PI_GAINS: [f64; 2] = [0.02, 0.06];

/// The controller with its state. Pairs are [right, left].
#[derive(Debug, Clone)]
pub(crate) struct Controller {
    /// Pose of the axle's middle by odometry: x, y (m), yaw (rad).
    pose: [f64; 3],
    /// Encoder counts at the last tick.
    counts: [i64; 2],
    /// Integrals of the speed errors (rad).
    integral: [f64; 2],
    /// Desired wheel speeds (rad/s).
    speeds: [f64; 2],
    /// Number of outer ticks so far.
    outer: usize,
    /// r, b, d (m) and counts per revolution.
    geometry: [f64; 4],
    /// Largest torque (N m).
    limit: f64,
}

impl Controller {
    /// A controller of a robot at rest with its centre of mass at `pose`; `counts` are the initial counts.
    pub(crate) fn new(pose: [f64; 3], counts: [i64; 2], geometry: [f64; 4], limit: f64) -> Self {
        let d = geometry[2];
        let axle = [
            pose[0] - d * pose[2].cos(),
            pose[1] - d * pose[2].sin(),
            pose[2],
        ];
        Self {
            pose: axle,
            counts,
            integral: [0.0; 2],
            speeds: [0.0; 2],
            outer: 0,
            geometry,
            limit,
        }
    }

    /// Encoder counts per revolution of a wheel.
    pub(crate) fn counts_per_rev(&self) -> f64 {
        self.geometry[3]
    }

    /// One tick of the inner loop, with one of the outer loop before it every 50 ms; returns the torques
    /// (N m).
    pub(crate) fn torque(
        &mut self,
        tick: usize,
        counts: [i64; 2],
        reference: &Reference,
    ) -> [f64; 2] {
        let [r, b, d, counts_per_rev] = self.geometry;
        let angle = [0, 1]
            .map(|i| (counts[i] - self.counts[i]) as f64 * std::f64::consts::TAU / counts_per_rev);
        self.counts = counts;
        let (along, turned) = (
            (angle[0] + angle[1]) * r / 2.0,
            (angle[0] - angle[1]) * r / (2.0 * b),
        );
        let heading = self.pose[2] + turned / 2.0;
        self.pose[0] += along * heading.cos();
        self.pose[1] += along * heading.sin();
        self.pose[2] += turned;
        if tick * 2 >= self.outer * 5 {
            self.outer += 1;
            let [v, w] = self.track(reference, d);
            self.speeds = [(v + b * w) / r, (v - b * w) / r];
        }
        [0, 1].map(|i| {
            let error = self.speeds[i] - angle[i] / COMMAND_PERIOD_S;
            let torque = PI_GAINS[0] * error + PI_GAINS[1] * self.integral[i];
            if torque.abs() < self.limit || torque * error < 0.0 {
                self.integral[i] += error * COMMAND_PERIOD_S;
            }
            torque.clamp(-self.limit, self.limit)
        })
    }

    /// Kanayama's law: desired [v (m/s), w (rad/s)].
    fn track(&self, reference: &Reference, d: f64) -> [f64; 2] {
        let [x, y, heading] = self.pose;
        let (sin, cos) = heading.sin_cos();
        let own = [x + d * cos, y + d * sin];
        let error = [reference.pose[0] - own[0], reference.pose[1] - own[1]];
        let (ahead, left) = (
            cos * error[0] + sin * error[1],
            cos * error[1] - sin * error[0],
        );
        let heading_error = reference.pose[2] - heading;
        let [v, w] = reference.speed;
        [
            v * heading_error.cos() + TRACKING_GAINS[0] * ahead,
            w + v * (TRACKING_GAINS[1] * left + TRACKING_GAINS[2] * heading_error.sin()),
        ]
    }
}
