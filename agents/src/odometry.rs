//! Odometry: dead reckoning from encoder counts (Eq. 1, section 3), with the midpoint rule.
//!
//! It assumes pure rolling, so that wheel slip makes it wrong; that is what the paper investigates.

use crate::geometry::Geometry;
use crate::pose::Pose;

/// Estimated pose of the midpoint of the axle.
#[derive(Debug, Clone)]
pub struct Odometry {
    axle: Pose,
    counts: Option<[i64; 2]>,
}

impl Odometry {
    /// Starts with c at `start`. The first reading of the counters is the origin of the counts.
    pub fn new(start: Pose, geometry: &Geometry) -> Self {
        Self {
            axle: start.ahead(-geometry.d),
            counts: None,
        }
    }

    /// Continues with c at `pose` when the counters read `counts`.
    pub fn resumed(pose: Pose, counts: [i64; 2], geometry: &Geometry) -> Self {
        Self {
            axle: pose.ahead(-geometry.d),
            counts: Some(counts),
        }
    }

    /// The last reading of the counters; 0 before the first.
    pub fn counts(&self) -> [i64; 2] {
        self.counts.unwrap_or_default()
    }

    /// Integrates the wheel rotation since the last reading of the counters.
    pub fn update(&mut self, counts: [i64; 2], geometry: &Geometry) {
        let before = self.counts.replace(counts).unwrap_or(counts);
        let [right, left] = wheel_rotation(before, counts, geometry);
        let [path_m, turn_rad] = geometry.twist([right, left]);
        self.axle = self.axle.along_arc(path_m, turn_rad);
    }

    /// The pose of the midpoint of the axle.
    pub fn axle(&self) -> Pose {
        self.axle
    }

    /// The pose of c.
    pub fn centre_of_mass(&self, geometry: &Geometry) -> Pose {
        self.axle.ahead(geometry.d)
    }
}

/// Rotation of the wheels between two readings of the counters (rad).
#[expect(
    clippy::cast_precision_loss,
    reason = "a difference of counts in one tick is far below 2^53"
)]
pub(crate) fn wheel_rotation(before: [i64; 2], now: [i64; 2], geometry: &Geometry) -> [f64; 2] {
    [0, 1].map(|i| now[i].wrapping_sub(before[i]) as f64 * geometry.count_rad)
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;

    /// A full circle in small steps returns to its start: the error of a chord is of third order.
    #[test]
    fn a_full_circle_closes() {
        let geometry = Geometry::new(&RobotModel::default()).unwrap();
        let start = Pose::new([1.0, 2.0, 0.3]);
        let mut odometry = Odometry::new(start, &geometry);
        odometry.update([0, 0], &geometry);
        // Right wheel 4 counts, left wheel 2 counts per step: a step turns by 2 counts · r / 2b.
        let step_rad = 2.0 * geometry.count_rad * geometry.r / (2.0 * geometry.b);
        let steps = (std::f64::consts::TAU / step_rad).round() as i64;
        for k in 1..=steps {
            odometry.update([4 * k, 2 * k], &geometry);
        }
        let end = odometry.centre_of_mass(&geometry);
        assert!((end.yaw_rad - start.yaw_rad - std::f64::consts::TAU).abs() < step_rad);
        assert!((end.x_m - start.x_m).hypot(end.y_m - start.y_m) < 1e-3);
    }

    #[test]
    fn a_turn_on_the_spot_moves_c_around_the_axle() {
        let geometry = Geometry::new(&RobotModel::default()).unwrap();
        let mut odometry = Odometry::new(Pose::default(), &geometry);
        odometry.update([100, 100], &geometry);
        odometry.update([600, -400], &geometry);
        assert!((odometry.axle().x_m + geometry.d).abs() < 1e-12);
        let yaw = odometry.axle().yaw_rad;
        let c = odometry.centre_of_mass(&geometry);
        assert!((c.y_m - geometry.d * yaw.sin()).abs() < 1e-12);
    }
}
