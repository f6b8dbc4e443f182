//! The way that a robot drove, and how far another one is behind it.

use std::collections::VecDeque;

/// Distance between two points of a path (m): poses stray by less.
const STEP_M: f64 = 0.03;
/// A path is kept for so many points.
const MOST: usize = 512;
/// The way before the first point, as far as anybody knows (m): straight on.
const BEFORE_M: f64 = 5.0;
/// A robot that is further aside (m) does not follow.
const ASIDE_M: f64 = 0.5;
/// Where a path crosses itself, places nearly as near (m) count, too: the one ahead is the last of them.
const NEARLY_M: f64 = 0.15;

/// The way of a robot.
#[derive(Debug, Clone, Default)]
pub(super) struct Path {
    /// x, y, and the way up to there (m).
    points: VecDeque<[f64; 3]>,
    /// Where it is now, as above.
    head: Option<[f64; 3]>,
}

impl Path {
    /// The robot is at x, y (m) and looks into a direction (rad); the way so far (m).
    pub(super) fn drive(&mut self, [x_m, y_m, yaw_rad]: [f64; 3]) -> f64 {
        let Some([at_x, at_y, way_m]) = self.points.back().copied() else {
            let (sin, cos) = yaw_rad.sin_cos();
            let before = [x_m - BEFORE_M * cos, y_m - BEFORE_M * sin, -BEFORE_M];
            self.points.extend([before, [x_m, y_m, 0.0]]);
            self.head = Some([x_m, y_m, 0.0]);
            return 0.0;
        };
        let step_m = (x_m - at_x).hypot(y_m - at_y);
        let head = [x_m, y_m, way_m + step_m];
        if step_m >= STEP_M {
            self.points.push_back(head);
            if self.points.len() > MOST {
                self.points.pop_front();
            }
        }
        self.head = Some(head);
        head[2]
    }

    /// The way (m) up to the place where a robot that follows is; `None` if it is beside or ahead.
    pub(super) fn place_m(&self, at: [f64; 2]) -> Option<f64> {
        let ahead = self.points.iter().rev();
        let all: Vec<[f64; 3]> = self.head.iter().chain(ahead).copied().collect();
        let places: Vec<(f64, f64)> = all
            .windows(2)
            .map(|pair| nearest(pair[1], pair[0], at))
            .collect();
        let least_m = places.iter().map(|own| own.0).fold(ASIDE_M, f64::min);
        let is_place = |i: usize| {
            let own_m = places[i].0;
            let beside = [i.checked_sub(1), Some(i + 1)].into_iter().flatten();
            let mut others = beside.filter_map(|j| places.get(j));
            own_m <= least_m + NEARLY_M && others.all(|other| own_m <= other.0)
        };
        let first = (0..places.len()).find(|i| is_place(*i))?;
        let (aside_m, way_m) = places[first];
        let head_m = self.head?[2];
        (aside_m < ASIDE_M && way_m < head_m).then_some(way_m)
    }
}

/// How far a point is from a piece of a path (m), and the way (m) up to the place that is nearest.
fn nearest(from: [f64; 3], to: [f64; 3], [x_m, y_m]: [f64; 2]) -> (f64, f64) {
    let along = [to[0] - from[0], to[1] - from[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let dot = (x_m - from[0]) * along[0] + (y_m - from[1]) * along[1];
    let share = if square > 0.0 {
        (dot / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let [at_x, at_y] = [0, 1].map(|i| from[i] + share * along[i]);
    let way_m = from[2] + share * (to[2] - from[2]);
    ((x_m - at_x).hypot(y_m - at_y), way_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_follower_is_behind_along_the_path() {
        let mut path = Path::default();
        // a quarter of a circle of radius 1 m to the left
        let at = |angle: f64| [angle.sin(), 1.0 - angle.cos(), angle];
        let mut way_m = 0.0;
        for k in 0..=90 {
            way_m = path.drive(at(f64::from(k).to_radians()));
        }
        assert!((way_m - std::f64::consts::FRAC_PI_2).abs() < 1e-3);
        let [x_m, y_m, angle] = at(0.7);
        let place_m = path.place_m([x_m, y_m]).unwrap();
        assert!((place_m - angle).abs() < 2e-3, "{place_m}");
        // before it began, straight on; ahead and aside it follows nobody
        assert!((path.place_m([-0.6, 0.0]).unwrap() + 0.6).abs() < 1e-9);
        assert_eq!(path.place_m([1.0, 1.2]), None);
        assert_eq!(path.place_m([-0.6, 0.8]), None);
    }
}
