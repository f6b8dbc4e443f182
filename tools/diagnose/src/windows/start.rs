//! Where a fit of a window's start begins.

use crate::windows::fit::Problem;
use crate::windows::track::Sensor;
use crate::windows::window::{LOCALS, Window};

/// A first guess of the unknowns at a window's start: from the measurements near it, and where a
/// camera sees positions alone, turned so that the path predicted by `problem` lies on the measured
/// one.
pub(crate) fn guess(problem: &Problem<'_>, values: &[f64], window: &Window) -> [f64; LOCALS] {
    let track = &problem.tracks[window.run];
    let near = window.guess(track, &problem.model.robot);
    turned(problem, values, window, &near).unwrap_or(near)
}

/// The start turned about its place by the angle that brings predicted positions closest to measured
/// ones (Procrustes). `None` where yaw is measured, or no position is.
fn turned(
    problem: &Problem<'_>,
    values: &[f64],
    window: &Window,
    start: &[f64; LOCALS],
) -> Option<[f64; LOCALS]> {
    let track = &problem.tracks[window.run];
    let at = track.series.iter().position(|s| s.sensor == Sensor::Pose)?;
    let mut poses = window.measured(track, at);
    if poses.any(|(_, pose, _)| pose[2].is_finite()) {
        return None;
    }
    let robots = problem.robots(values).ok()?;
    let residuals = problem.simulation(window, &robots).residuals(start);
    let (mut along, mut across) = (0.0, 0.0);
    for (_, seen, base) in window.measured(track, at) {
        let deviation = track.series[at].deviation;
        let [x, y] = [seen[0] - start[0], seen[1] - start[1]];
        let [px, py] = [0, 1].map(|i| residuals[base + i] * deviation[i]);
        if px.is_finite() && py.is_finite() {
            along += x * (x + px) + y * (y + py);
            across += y * (x + px) - x * (y + py);
        }
    }
    let mut turned = *start;
    turned[2] += across.atan2(along);
    Some(turned)
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;
    use slipstream_sim::Command;

    use crate::windows::fixture;
    use crate::windows::track::Sensor;

    const SPEEDS_RAD_S: [f64; 2] = [6.0, 4.0];

    /// Where c is after `t_s` on an arc that begins at (0.3, -0.2) m with heading `yaw`: the middle of
    /// the axle, d behind c, goes round a circle.
    fn arc(model: &RobotModel, yaw: f64, t_s: f64) -> [f64; 3] {
        let body = &model.robot;
        let ahead_m = body.com_to_axle_m.unwrap();
        let [right, left] = SPEEDS_RAD_S.map(|speed| speed * body.wheel_radius_m);
        let rate = (right - left) / (2.0 * body.half_track_m);
        let radius_m = (right + left) / 2.0 / rate;
        let now = yaw + rate * t_s;
        [
            0.3 + radius_m * (now.sin() - yaw.sin()) + ahead_m * (now.cos() - yaw.cos()),
            -0.2 - radius_m * (now.cos() - yaw.cos()) + ahead_m * (now.sin() - yaw.sin()),
            now,
        ]
    }

    fn guess(yaw: f64, sees_yaw: bool) -> [f64; 3] {
        let model = RobotModel::default();
        let [right_rad_s, left_rad_s] = SPEEDS_RAD_S;
        let command = Command::Speed {
            right_rad_s,
            left_rad_s,
        };
        let seen = |k: u32| {
            let t_s = f64::from(k) * 0.05;
            let [x, y, yaw] = arc(&model, yaw, t_s);
            (t_s, [x, y, if sees_yaw { yaw } else { f64::NAN }])
        };
        let poses = fixture::series(Sensor::Pose, (0..100).map(seen).collect(), 2e-3);
        let bench = fixture::bench(fixture::track(vec![(0.0, command)], vec![poses]), model);
        let guesses = bench.guesses(&bench.windows).unwrap();
        [guesses[0][0], guesses[0][1], guesses[0][2]]
    }

    #[test]
    fn positions_alone_say_which_way_the_robot_faced() {
        for yaw in [-2.9, -1.0, 0.0, 0.4, 2.0] {
            let [x, y, found] = guess(yaw, false);
            assert_eq!([x, y], [0.3, -0.2]);
            // the path is exact but for what lies between steps of 20 ms
            assert!((found - yaw).abs() < 1e-5, "{found} for {yaw}");
        }
    }

    #[test]
    fn a_heading_that_was_seen_is_believed() {
        let [_, _, found] = guess(2.0, true);
        assert_eq!(found, 2.0);
    }
}
