//! The true distance between a follower and the robot ahead, along the path that that one drove.

use std::collections::VecDeque;

/// Two kept points are at least this far apart (m).
const GRAIN_M: f64 = 0.02;
/// Points that are kept: the newest so many.
const ROOM: usize = 4096;

/// Between two looks a follower moves by less than this along the path (m). Where the path crosses
/// itself, this says on which of its branches the follower is.
const REACH_M: f64 = 0.5;

/// A point of the path of c.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    s_m: f64,
    x_m: f64,
    y_m: f64,
}

/// The path that one robot drove, and where on it its follower is.
#[derive(Debug, Clone)]
pub(super) struct Spacing {
    points: VecDeque<Point>,
    newest: Point,
    /// The direction of the straight line behind the first point.
    start_yaw_rad: f64,
    forgotten: bool,
    /// Where on the path the follower was when last looked at (m).
    foot_m: Option<f64>,
}

impl Spacing {
    /// The robot ahead at its start.
    pub(super) fn new([x_m, y_m, yaw_rad]: [f64; 3]) -> Self {
        let newest = Point { s_m: 0.0, x_m, y_m };
        let mut points = VecDeque::with_capacity(ROOM);
        points.push_back(newest);
        Self {
            points,
            newest,
            start_yaw_rad: yaw_rad,
            forgotten: false,
            foot_m: None,
        }
    }

    /// The robot ahead drove on to a pose.
    pub(super) fn extend(&mut self, [x_m, y_m, yaw_rad]: [f64; 3]) {
        let (dx, dy) = (x_m - self.newest.x_m, y_m - self.newest.y_m);
        let (sin, cos) = yaw_rad.sin_cos();
        let ds = dx.hypot(dy).copysign(dx * cos + dy * sin);
        self.newest = Point {
            s_m: self.newest.s_m + ds,
            x_m,
            y_m,
        };
        while self.points.len() > 1 && self.points[self.points.len() - 1].s_m >= self.newest.s_m {
            self.points.pop_back();
        }
        if self.newest.s_m - self.points[self.points.len() - 1].s_m >= GRAIN_M {
            if self.points.len() == ROOM {
                self.points.pop_front();
                self.forgotten = true;
            }
            self.points.push_back(self.newest);
        }
    }

    /// Distance along the path from the point nearest to a follower's c up to the robot ahead (m).
    pub(super) fn behind(&mut self, [x_m, y_m, _]: [f64; 3]) -> f64 {
        let foot_m = self.foot_m;
        let near = |s_m: f64| foot_m.is_none_or(|foot_m| (s_m - foot_m).abs() <= REACH_M);
        let mut best = (f64::INFINITY, foot_m.unwrap_or(0.0));
        let mut offer = |distance: f64, s_m: f64| {
            if distance < best.0 && near(s_m) {
                best = (distance, s_m);
            }
        };
        if !self.forgotten {
            let first = self.points[0];
            let (sin, cos) = self.start_yaw_rad.sin_cos();
            let (dx, dy) = (x_m - first.x_m, y_m - first.y_m);
            let along = (dx * cos + dy * sin).min(0.0);
            offer(
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
            offer(distance, a.s_m + share * (b.s_m - a.s_m));
        }
        self.foot_m = Some(best.1);
        self.newest.s_m - best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_a_straight_line_it_is_the_distance() {
        let mut spacing = Spacing::new([0.6096, 0.0, 0.0]);
        assert!((spacing.behind([0.0, 0.0, 0.0]) - 0.6096).abs() < 1e-15);
        for k in 1..400 {
            let x = 0.6096 + 0.003 * f64::from(k);
            spacing.extend([x, 0.0, 0.0]);
            let behind = spacing.behind([x - 0.5, 0.1, 0.3]);
            assert!((behind - 0.5).abs() < 1e-12, "{k} {behind}");
        }
    }

    /// Two rounds of a circle: the follower is on the branch on which it was.
    #[test]
    fn where_the_path_crosses_itself_it_is_still_the_way() {
        let on_circle = |angle: f64| [angle.sin(), 1.0 - angle.cos(), angle];
        let mut spacing = Spacing::new(on_circle(0.0));
        for k in 1..=1200 {
            let angle = f64::from(k) * 0.01;
            spacing.extend(on_circle(angle));
            if angle > 0.7 {
                let behind = spacing.behind(on_circle(angle - 0.6));
                assert!((behind - 0.6).abs() < 1e-3, "{k} {behind}");
            }
        }
    }

    #[test]
    fn around_a_corner_it_is_the_way() {
        let on_circle = |angle: f64| [angle.sin(), 1.0 - angle.cos(), angle];
        let mut spacing = Spacing::new(on_circle(0.0));
        for k in 1..=200 {
            spacing.extend(on_circle(f64::from(k) * 0.01));
        }
        let behind = spacing.behind(on_circle(1.3));
        assert!((behind - 0.7).abs() < 1e-3, "{behind}");
    }
}
