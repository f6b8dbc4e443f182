//! Where the wheels say the robot is: dead reckoning from encoder counts, as in the paper.

use crate::geometry::Geometry;
use crate::pose::Pose;

/// Dead reckoning of the axle's middle.
#[derive(Debug, Clone)]
pub struct Odometry {
    axle: Pose,
    counts: Option<[i64; 2]>,
}

impl Odometry {
    /// Begins with c at `start`, at whatever the counters first show.
    pub fn new(start: Pose, geometry: &Geometry) -> Self {
        Self {
            axle: start.ahead(-geometry.d),
            counts: None,
        }
    }

    /// Goes on with c at `pose` when the counters showed `counts`.
    pub fn resumed(pose: Pose, counts: [i64; 2], geometry: &Geometry) -> Self {
        Self {
            axle: pose.ahead(-geometry.d),
            counts: Some(counts),
        }
    }

    /// The counters behind the pose; 0 before the first reading.
    pub fn counts(&self) -> [i64; 2] {
        self.counts.unwrap_or_default()
    }

    /// Takes in the counters.
    pub fn update(&mut self, counts: [i64; 2], geometry: &Geometry) {
        let before = self.counts.replace(counts).unwrap_or(counts);
        let [right, left] = turned(before, counts, geometry);
        let [path_m, turn_rad] = geometry.twist([right, left]);
        self.axle = self.axle.driven(path_m, turn_rad);
    }

    /// The pose of the axle's middle.
    pub fn axle(&self) -> Pose {
        self.axle
    }

    /// The pose of c.
    pub fn centre_of_mass(&self, geometry: &Geometry) -> Pose {
        self.axle.ahead(geometry.d)
    }
}

/// How far the wheels turned between two readings (rad).
#[expect(
    clippy::cast_precision_loss,
    reason = "a difference of counts in one tick is far below 2^53"
)]
pub(crate) fn turned(before: [i64; 2], now: [i64; 2], geometry: &Geometry) -> [f64; 2] {
    [0, 1].map(|i| now[i].wrapping_sub(before[i]) as f64 * geometry.count_rad)
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;

    /// A full circle in small steps comes back to its start: the error of the chord is third order.
    #[test]
    fn a_full_circle_closes() {
        let geometry = Geometry::new(&RobotModel::default()).unwrap();
        let start = Pose::new([1.0, 2.0, 0.3]);
        let mut odometry = Odometry::new(start, &geometry);
        odometry.update([0, 0], &geometry);
        // right wheel 4 counts, left wheel 2 counts a step: each step turns by 2 counts r / 2b
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
    fn a_turn_on_the_spot_swings_c_about_the_axle() {
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
