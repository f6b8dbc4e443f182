//! A robot's own controller: Kanayama's law at 20 Hz over encoder odometry, PI wheels at 50 Hz.

use super::manoeuvre::HOLD_S;

/// Gains of Kanayama's law: k_x (1/s), k_y (1/m²), k_θ (1/m).
const GAINS: [f64; 3] = [1.0, 12.0, 4.0];
/// Inner loop: N m s/rad and N m/rad.
const INNER: [f64; 2] = [0.02, 0.06];

/// What a controller remembers. Pairs are [right, left].
#[derive(Debug, Clone)]
pub(crate) struct Controller {
    /// Pose by odometry, of the axle's middle.
    pose: [f64; 3],
    counts: [i64; 2],
    integral: [f64; 2],
    speeds: [f64; 2],
    outer: usize,
    /// r, b, d and counts in a turn.
    geometry: [f64; 4],
    /// Largest torque (N m).
    limit: f64,
}

/// A pose and the speeds along it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reference {
    /// x, y of c (m) and heading (rad).
    pub(crate) pose: [f64; 3],
    /// v (m/s) and w (rad/s).
    pub(crate) speed: [f64; 2],
}

impl Controller {
    /// A controller of a robot that stands with c at `pose` and whose counters are `counts`.
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

    /// Counts in a turn of a wheel.
    pub(crate) fn counts_per_rev(&self) -> f64 {
        self.geometry[3]
    }

    /// One tick of the inner loop; every 50 ms one of the outer before it.
    pub(crate) fn torque(
        &mut self,
        tick: usize,
        counts: [i64; 2],
        reference: &Reference,
    ) -> [f64; 2] {
        let [r, b, d, turn] = self.geometry;
        let angle =
            [0, 1].map(|i| (counts[i] - self.counts[i]) as f64 * std::f64::consts::TAU / turn);
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
            let [v, w] = self.follow(reference, d);
            self.speeds = [(v + b * w) / r, (v - b * w) / r];
        }
        [0, 1].map(|i| {
            let error = self.speeds[i] - angle[i] / HOLD_S;
            let wanted = INNER[0] * error + INNER[1] * self.integral[i];
            if wanted.abs() < self.limit || wanted * error < 0.0 {
                self.integral[i] += error * HOLD_S;
            }
            wanted.clamp(-self.limit, self.limit)
        })
    }

    fn follow(&self, reference: &Reference, d: f64) -> [f64; 2] {
        let [x, y, heading] = self.pose;
        let (sin, cos) = heading.sin_cos();
        let own = [x + d * cos, y + d * sin];
        let away = [reference.pose[0] - own[0], reference.pose[1] - own[1]];
        let (ahead, left) = (cos * away[0] + sin * away[1], cos * away[1] - sin * away[0]);
        let turn = reference.pose[2] - heading;
        let [v, w] = reference.speed;
        [
            v * turn.cos() + GAINS[0] * ahead,
            w + v * (GAINS[1] * left + GAINS[2] * turn.sin()),
        ]
    }
}
