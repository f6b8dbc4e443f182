//! The path that the robot ahead drove, and the point of it that lies δ behind.
//!
//! q_ref = q_{i−1} − δ_i: on a straight line the point δ behind the one ahead; around a corner the
//! point where it was, so that a turning formation keeps its shape.

use std::collections::VecDeque;

use crate::pose::Pose;

/// A point of the path: a pose of c and the velocities sent with it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    /// Distance along the path (m).
    s_m: f64,
    pose: Pose,
    /// w_r / v_r there (1/m).
    curvature: f64,
}

/// A reference for the follower.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// The pose of c.
    pub pose: Pose,
    /// The path's curvature there (1/m).
    pub curvature: f64,
}

/// Two kept points are at least this far apart (m).
const GRAIN_M: f64 = 0.001;
/// Points that are kept: the newest so many.
const ROOM: usize = 4096;
/// Below this speed a curvature says nothing (m/s).
const SLOWEST_M_S: f64 = 0.01;

/// The path of the robot ahead as far as it is known.
#[derive(Debug, Clone)]
pub struct Path {
    points: VecDeque<Point>,
    /// The newest position, which need not be a grain away from the last point.
    newest: Point,
}

impl Path {
    /// A path that so far is one point; behind it the line straight back.
    pub fn new(start: Pose) -> Self {
        let newest = Point {
            s_m: 0.0,
            pose: start,
            curvature: 0.0,
        };
        let mut points = VecDeque::with_capacity(ROOM);
        points.push_back(newest);
        Self { points, newest }
    }

    /// Takes in a newer position of c with the velocities v_r (m/s) and w_r (rad/s) there.
    pub fn extend(&mut self, pose: Pose, [v, w]: [f64; 2]) {
        let from = self.newest;
        let (dx, dy) = (pose.x_m - from.pose.x_m, pose.y_m - from.pose.y_m);
        let (sin, cos) = from.pose.yaw_rad.sin_cos();
        let ds = dx.hypot(dy).copysign(dx * cos + dy * sin);
        let curvature = if v.abs() > SLOWEST_M_S {
            w / v
        } else {
            from.curvature
        };
        self.newest = Point {
            s_m: from.s_m + ds,
            pose,
            curvature,
        };
        // Who drives backwards takes back the path.
        while self.points.len() > 1 && self.points[self.points.len() - 1].s_m >= self.newest.s_m {
            self.points.pop_back();
        }
        if self.newest.s_m - self.points[self.points.len() - 1].s_m >= GRAIN_M {
            if self.points.len() == ROOM {
                self.points.pop_front();
            }
            self.points.push_back(self.newest);
        }
    }

    /// The newest position as it came, the path up to the given distance behind it forgotten.
    pub fn behind(&mut self, distance_m: f64) -> Reference {
        let s_m = self.newest.s_m - distance_m;
        while self.points.len() > 1 && self.points[1].s_m <= s_m {
            self.points.pop_front();
        }
        let first = self.points[0];
        if s_m <= first.s_m {
            let pose = first.pose.ahead(s_m - first.s_m);
            return Reference {
                pose,
                curvature: first.curvature,
            };
        }
        let second = self.points.get(1).copied().unwrap_or(self.newest);
        let span = second.s_m - first.s_m;
        let share = if span > 0.0 {
            ((s_m - first.s_m) / span).min(1.0)
        } else {
            1.0
        };
        let mix = |a: f64, b: f64| a + share * (b - a);
        Reference {
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
        let mut path = Path::new(Pose::new([0.6096, 0.0, 0.0]));
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

    /// On a circle of radius 1 the reference lies on the circle, not on the chord or the tangent.
    #[test]
    fn around_a_corner_the_reference_stays_on_the_path() {
        let on_circle = |angle: f64| Pose::new([angle.sin(), 1.0 - angle.cos(), angle]);
        let mut path = Path::new(on_circle(0.0));
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
    fn driving_backwards_takes_back_the_path() {
        let mut path = Path::new(Pose::default());
        for x in [0.1, 0.2, 0.3, 0.2, 0.1] {
            path.extend(Pose::new([x, 0.0, 0.0]), [0.1, 0.0]);
        }
        assert!((path.behind(0.05).pose.x_m - 0.05).abs() < 1e-12);
    }
}
