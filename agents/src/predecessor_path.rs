//! Path of the predecessor by arc length: the follower's reference is its point δ behind the end.
//!
//! q_ref = q_{i−1} − δ_i (section 4 of the paper). On a straight line this is the point δ behind
//! the predecessor; around a corner it is a point where the predecessor was, so that the followers
//! drive on the same path.

use std::collections::VecDeque;

use crate::pose::Pose;

/// A received position on the path.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Waypoint {
    /// Arc length along the path (m).
    s_m: f64,
    /// Pose of c.
    pose: Pose,
    /// w_r / v_r (1/m).
    curvature: f64,
}

/// An interpolated point of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Pose of c.
    pub pose: Pose,
    /// Curvature of the path (1/m).
    pub curvature: f64,
}

/// Smallest distance between two stored waypoints (m).
const MIN_DISTANCE_M: f64 = 0.001;
/// Largest number of stored waypoints; older ones are dropped.
const MAX_WAYPOINTS: usize = 4096;
/// Speed below which w_r / v_r is not a usable curvature (m/s).
const MIN_SPEED_M_S: f64 = 0.01;

/// The received path of the predecessor.
#[derive(Debug, Clone)]
pub struct PredecessorPath {
    waypoints: VecDeque<Waypoint>,
    /// The newest position. It is not stored if it is too close to the last waypoint.
    newest: Waypoint,
}

impl PredecessorPath {
    /// A path of one waypoint. Behind its first waypoint a path continues straight.
    pub fn new(start: Pose) -> Self {
        let newest = Waypoint {
            s_m: 0.0,
            pose: start,
            curvature: 0.0,
        };
        let mut waypoints = VecDeque::with_capacity(MAX_WAYPOINTS);
        waypoints.push_back(newest);
        Self { waypoints, newest }
    }

    /// Appends a newer position of c with the velocities v_r (m/s) and w_r (rad/s) sent with it.
    /// When the predecessor drives backwards, the end of the path is removed again.
    pub fn extend(&mut self, pose: Pose, [v, w]: [f64; 2]) {
        let from = self.newest;
        let (dx, dy) = (pose.x_m - from.pose.x_m, pose.y_m - from.pose.y_m);
        let (sin, cos) = from.pose.yaw_rad.sin_cos();
        let ds = dx.hypot(dy).copysign(dx * cos + dy * sin);
        let curvature = if v.abs() > MIN_SPEED_M_S {
            w / v
        } else {
            from.curvature
        };
        self.newest = Waypoint {
            s_m: from.s_m + ds,
            pose,
            curvature,
        };
        while self.waypoints.len() > 1 && self.last().s_m >= self.newest.s_m {
            self.waypoints.pop_back();
        }
        if self.newest.s_m - self.last().s_m >= MIN_DISTANCE_M {
            if self.waypoints.len() == MAX_WAYPOINTS {
                self.waypoints.pop_front();
            }
            self.waypoints.push_back(self.newest);
        }
    }

    /// The last stored waypoint; there is always one.
    fn last(&self) -> &Waypoint {
        &self.waypoints[self.waypoints.len() - 1]
    }

    /// The point of the path `distance_m` behind its end, linearly interpolated between waypoints.
    /// Drops the waypoints behind that point.
    pub fn behind(&mut self, distance_m: f64) -> PathPoint {
        let s_m = self.newest.s_m - distance_m;
        while self.waypoints.len() > 1 && self.waypoints[1].s_m <= s_m {
            self.waypoints.pop_front();
        }
        let first = self.waypoints[0];
        if s_m <= first.s_m {
            let pose = first.pose.ahead(s_m - first.s_m);
            return PathPoint {
                pose,
                curvature: first.curvature,
            };
        }
        let second = self.waypoints.get(1).copied().unwrap_or(self.newest);
        let distance = second.s_m - first.s_m;
        let fraction = if distance > 0.0 {
            ((s_m - first.s_m) / distance).min(1.0)
        } else {
            1.0
        };
        let mix = |a: f64, b: f64| a + fraction * (b - a);
        PathPoint {
            pose: Pose {
                x_m: mix(first.pose.x_m, second.pose.x_m),
                y_m: mix(first.pose.y_m, second.pose.y_m),
                yaw_rad: mix(first.pose.yaw_rad, second.pose.yaw_rad),
            },
            curvature: mix(first.curvature, second.curvature),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_a_straight_line_the_reference_is_the_distance_behind() {
        let mut path = PredecessorPath::new(Pose::new([0.6096, 0.0, 0.0]));
        assert_eq!(path.behind(0.6096).pose.x_m, 0.0);
        for k in 1..100 {
            let x = 0.6096 + 0.013 * f64::from(k);
            path.extend(Pose::new([x, 0.0, 0.0]), [0.26, 0.0]);
            let reference = path.behind(0.6096);
            assert!(
                (reference.pose.x_m - (x - 0.6096)).abs() < 1e-12,
                "{k} {reference:?}"
            );
        }
    }

    /// On a circle of radius 1 m the reference is on the circle, not on a chord or a tangent.
    #[test]
    fn around_a_corner_the_reference_stays_on_the_path() {
        let on_circle = |angle: f64| Pose::new([angle.sin(), 1.0 - angle.cos(), angle]);
        let mut path = PredecessorPath::new(on_circle(0.0));
        let mut angle = 0.0;
        for _ in 0..100 {
            angle += 0.02;
            path.extend(on_circle(angle), [0.4, 0.4]);
        }
        let reference = path.behind(0.6);
        let expected = on_circle(angle - 0.6);
        assert!(
            (reference.pose.x_m - expected.x_m).abs() < 1e-3,
            "{reference:?}"
        );
        assert!(
            (reference.pose.y_m - expected.y_m).abs() < 1e-3,
            "{reference:?}"
        );
        assert!((reference.pose.yaw_rad - expected.yaw_rad).abs() < 1e-3);
        assert!((reference.curvature - 1.0).abs() < 1e-12);
    }

    #[test]
    fn driving_backwards_shortens_the_path() {
        let mut path = PredecessorPath::new(Pose::default());
        for x in [0.1, 0.2, 0.3, 0.2, 0.1] {
            path.extend(Pose::new([x, 0.0, 0.0]), [0.1, 0.0]);
        }
        assert!((path.behind(0.05).pose.x_m - 0.05).abs() < 1e-12);
    }
}
