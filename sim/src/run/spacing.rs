//! Spacing between a follower and the robot ahead: distance along the path that the latter has driven.

use std::collections::VecDeque;

/// Time from which spacing errors count (s): robots that start have no path yet to be followed.
pub const SPACING_FROM_S: f64 = 3.0;

/// Smallest distance between two stored points of the path (m).
const POINT_SPACING_M: f64 = 0.02;
/// Largest number of stored points; older ones are dropped.
const CAPACITY: usize = 4096;

/// Largest movement of a follower along the path between two measurements (m): where the path
/// crosses itself, it selects the branch on which the follower is.
const REACH_M: f64 = 0.5;

/// A point of the path of c, with its arc length.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PathPoint {
    s_m: f64,
    x_m: f64,
    y_m: f64,
}

/// The path that one robot has driven, and the position of its follower on it.
#[derive(Debug, Clone)]
pub struct Spacing {
    points: VecDeque<PathPoint>,
    newest: PathPoint,
    /// Direction of the path before the first point, which is taken as straight.
    start_yaw_rad: f64,
    /// The first point has been dropped.
    truncated: bool,
    /// Arc length of the follower's nearest point at the last measurement (m).
    foot_m: Option<f64>,
}

impl Spacing {
    /// The path of a robot whose c starts at this pose: x and y (m), heading (rad).
    pub fn new([x_m, y_m, yaw_rad]: [f64; 3]) -> Self {
        let newest = PathPoint { s_m: 0.0, x_m, y_m };
        let mut points = VecDeque::with_capacity(CAPACITY);
        points.push_back(newest);
        Self {
            points,
            newest,
            start_yaw_rad: yaw_rad,
            truncated: false,
            foot_m: None,
        }
    }

    /// Extends the path to the present pose of the robot's c: x and y (m), heading (rad).
    pub fn extend(&mut self, [x_m, y_m, yaw_rad]: [f64; 3]) {
        let (dx, dy) = (x_m - self.newest.x_m, y_m - self.newest.y_m);
        let (sin, cos) = yaw_rad.sin_cos();
        let ds = dx.hypot(dy).copysign(dx * cos + dy * sin);
        self.newest = PathPoint {
            s_m: self.newest.s_m + ds,
            x_m,
            y_m,
        };
        while self.points.len() > 1 && self.points[self.points.len() - 1].s_m >= self.newest.s_m {
            self.points.pop_back();
        }
        if self.newest.s_m - self.points[self.points.len() - 1].s_m >= POINT_SPACING_M {
            if self.points.len() == CAPACITY {
                self.points.pop_front();
                self.truncated = true;
            }
            self.points.push_back(self.newest);
        }
    }

    /// Distance along the path from the point nearest to the follower's c to the robot ahead (m).
    pub fn distance(&mut self, [x_m, y_m, _]: [f64; 3]) -> f64 {
        let foot_m = self.foot_m;
        let near = |s_m: f64| foot_m.is_none_or(|foot_m| (s_m - foot_m).abs() <= REACH_M);
        // distance and arc length of the nearest point so far
        let mut nearest = (f64::INFINITY, foot_m.unwrap_or(0.0));
        let mut consider = |distance: f64, s_m: f64| {
            if distance < nearest.0 && near(s_m) {
                nearest = (distance, s_m);
            }
        };
        if !self.truncated {
            let first = self.points[0];
            let (sin, cos) = self.start_yaw_rad.sin_cos();
            let (dx, dy) = (x_m - first.x_m, y_m - first.y_m);
            let along = (dx * cos + dy * sin).min(0.0);
            consider(
                (dx - along * cos).hypot(dy - along * sin),
                first.s_m + along,
            );
        }
        let ends = self
            .points
            .iter()
            .skip(1)
            .chain(std::iter::once(&self.newest));
        for (a, b) in self.points.iter().zip(ends) {
            let (ux, uy) = (b.x_m - a.x_m, b.y_m - a.y_m);
            let length2 = ux * ux + uy * uy;
            if length2 == 0.0 {
                continue;
            }
            let (dx, dy) = (x_m - a.x_m, y_m - a.y_m);
            let share = ((dx * ux + dy * uy) / length2).clamp(0.0, 1.0);
            let distance = (dx - share * ux).hypot(dy - share * uy);
            consider(distance, a.s_m + share * (b.s_m - a.s_m));
        }
        self.foot_m = Some(nearest.1);
        self.newest.s_m - nearest.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_the_distance_on_a_straight_line() {
        let mut spacing = Spacing::new([0.6096, 0.0, 0.0]);
        assert!((spacing.distance([0.0, 0.0, 0.0]) - 0.6096).abs() < 1e-15);
        for k in 1..400 {
            let x = 0.6096 + 0.003 * f64::from(k);
            spacing.extend([x, 0.0, 0.0]);
            let distance = spacing.distance([x - 0.5, 0.1, 0.3]);
            assert!((distance - 0.5).abs() < 1e-12, "{k} {distance}");
        }
    }

    /// Two rounds of a circle: the follower stays on its branch.
    #[test]
    fn stays_on_its_branch_where_the_path_crosses_itself() {
        let on_circle = |angle: f64| [angle.sin(), 1.0 - angle.cos(), angle];
        let mut spacing = Spacing::new(on_circle(0.0));
        for k in 1..=1200 {
            let angle = f64::from(k) * 0.01;
            spacing.extend(on_circle(angle));
            if angle > 0.7 {
                let distance = spacing.distance(on_circle(angle - 0.6));
                assert!((distance - 0.6).abs() < 1e-3, "{k} {distance}");
            }
        }
    }

    #[test]
    fn is_the_arc_length_in_a_bend() {
        let on_circle = |angle: f64| [angle.sin(), 1.0 - angle.cos(), angle];
        let mut spacing = Spacing::new(on_circle(0.0));
        for k in 1..=200 {
            spacing.extend(on_circle(f64::from(k) * 0.01));
        }
        let distance = spacing.distance(on_circle(1.3));
        assert!((distance - 0.7).abs() < 1e-3, "{distance}");
    }
}
