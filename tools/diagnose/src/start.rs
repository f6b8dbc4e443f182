//! Where a fit of a window's start begins.

use crate::fit::Problem;
use crate::track::Sensor;
use crate::window::{LOCALS, Window};

/// A first guess of the unknowns at a window's start: from the measurements near it, and where a
/// camera sees positions alone, turned so that the path predicted by `problem` lies on the measured
/// one.
pub(crate) fn guess(problem: &Problem<'_>, values: &[f64], window: &Window) -> [f64; LOCALS] {
    let track = &problem.tracks[window.run];
    let body = &problem.model.robot;
    let near = window.guess(track, body.wheel_radius_m, body.half_track_m);
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
