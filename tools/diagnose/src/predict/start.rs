//! The state at the start of a window, fitted to the window: pose, surge, yaw rate and wheel angles.

use nalgebra::{SMatrix, SVector};
use slipstream_bus::Body;

use crate::data::track::{Sensor, Track};
use crate::predict::simulation::Simulated;
use crate::predict::sum_of_squares::SumOfSquares;
use crate::predict::window::{LOCALS, Window};

/// Iterations of a fit.
const ITERATIONS: usize = 20;
/// A fit has arrived where a step brings less than this (−2 ln L), or less than this share of what is
/// left.
const ARRIVED: f64 = 0.02;
const SHARE: f64 = 1e-4;
/// First damping, the least, and how often it is raised for one step.
const DAMPING: f64 = 1e-4;
const LEAST_DAMPING: f64 = 1e-9;
const TRIES: usize = 6;
/// Steps of the differences for heading (rad), surge (m/s) and yaw rate (rad/s).
const HEADING_STEP: f64 = 1e-4;
const SPEED_STEPS: [f64; 2] = [1e-4, 1e-3];

/// A window whose start is fitted.
pub(crate) struct Start<'a> {
    simulated: &'a Simulated,
    track: &'a Track,
    window: &'a Window,
    at: [f64; LOCALS],
    residuals: Vec<f64>,
}

impl<'a> Start<'a> {
    /// A first guess: from the measurements near the start, and where a camera sees positions alone,
    /// turned so that the predicted path lies on the measured one.
    pub(crate) fn guess(
        simulated: &'a Simulated,
        track: &'a Track,
        window: &'a Window,
        body: &Body,
    ) -> Self {
        let simulation = simulated.over(track, window);
        let mut near = window.guess(track, body);
        let poses = track.place(Sensor::Pose);
        if poses.is_some_and(|at| window.measured(track, at).next().is_some()) {
            near = unmounted(&near, simulated, track.tracked_ahead_m);
        }
        let seen = simulation.residuals(&near);
        let (at, residuals) = match turned(track, window, &near, &seen) {
            Some(at) => (at, simulation.residuals(&at)),
            None => (near, seen),
        };
        Self {
            simulated,
            track,
            window,
            at,
            residuals,
        }
    }

    /// How many poses are compared.
    pub(crate) fn poses(&self) -> usize {
        let first = Sensor::Pose.channel();
        let pairs = self.window.channels.iter().zip(&self.residuals);
        pairs
            .filter(|(c, r)| usize::from(**c) == first && r.is_finite())
            .count()
    }

    /// The start by Levenberg and Marquardt. `None` where nothing is finite.
    pub(crate) fn fitted(mut self) -> Option<[f64; LOCALS]> {
        let mut squares = SumOfSquares::new(self.window, &self.residuals);
        let mut damping = DAMPING;
        if !squares.deviance().is_finite() {
            return None;
        }
        for _ in 0..ITERATIONS {
            let (normal, slope) = self.normal(&squares.weights());
            let before = squares.deviance();
            let next = (0..TRIES).find_map(|_| {
                let next = self.stepped(&normal, &slope, damping, before);
                damping = match next {
                    Some(_) => (damping * 0.1).max(LEAST_DAMPING),
                    None => (damping * 10.0).max(DAMPING),
                };
                next
            });
            let Some((at, residuals, better)) = next else {
                break;
            };
            let gained = before - better.deviance();
            (self.at, self.residuals, squares) = (at, residuals, better);
            if gained < ARRIVED.max(SHARE * before) {
                break;
            }
        }
        Some(self.at)
    }

    fn stepped(
        &self,
        normal: &SMatrix<f64, LOCALS, LOCALS>,
        slope: &SVector<f64, LOCALS>,
        damping: f64,
        before: f64,
    ) -> Option<([f64; LOCALS], Vec<f64>, SumOfSquares)> {
        let mut damped = *normal;
        for i in 0..LOCALS {
            // what the window does not show keeps its value
            damped[(i, i)] = if normal[(i, i)] > 0.0 {
                normal[(i, i)] * (1.0 + damping)
            } else {
                1.0
            };
        }
        let step = damped.lu().solve(slope)?;
        let at = std::array::from_fn(|i| self.at[i] - step[i]);
        let residuals = self.simulated.over(self.track, self.window).residuals(&at);
        let squares = SumOfSquares::new(self.window, &residuals);
        (squares.deviance() < before).then_some((at, residuals, squares))
    }

    /// The normal equations under these weights of the channels.
    fn normal(&self, weights: &[f64]) -> (SMatrix<f64, LOCALS, LOCALS>, SVector<f64, LOCALS>) {
        let columns = self.columns();
        let (mut normal, mut slope) = (SMatrix::zeros(), SVector::zeros());
        let rows = self.residuals.iter().zip(&self.window.channels);
        for (i, (residual, channel)) in rows.enumerate() {
            if !residual.is_finite() {
                continue;
            }
            let row = SVector::<f64, LOCALS>::from_fn(|k, _| {
                let own = columns[k][i];
                // a derivative is NaN where a residual fell out of the window
                if own.is_finite() { own } else { 0.0 }
            });
            let weight = weights[usize::from(*channel)];
            normal += row * row.transpose() * weight;
            slope += row * (weight * residual);
        }
        (normal, slope)
    }

    /// How residuals move with each unknown of the start.
    fn columns(&self) -> Vec<Vec<f64>> {
        let simulation = self.simulated.over(self.track, self.window);
        let mut columns = rigid(self.track, self.window, &self.at, &self.residuals);
        let difference = |i: usize, step: f64| {
            let mut moved = self.at;
            moved[i] += step;
            let after = simulation.residuals(&moved);
            let pairs = after.iter().zip(&self.residuals);
            pairs
                .map(|(after, before)| (after - before) / step)
                .collect::<Vec<f64>>()
        };
        if self.simulated.bound_to_place && self.window.free[2] {
            columns[2] = difference(2, HEADING_STEP);
        }
        if self.window.free[3] {
            columns[3] = difference(3, SPEED_STEPS[0]);
            columns[4] = difference(4, SPEED_STEPS[1]);
        }
        columns
    }
}

/// The start turned about its place by the angle that brings predicted positions closest to measured
/// ones (Procrustes). `None` where yaw is measured, or no position is.
fn turned(
    track: &Track,
    window: &Window,
    start: &[f64; LOCALS],
    residuals: &[f64],
) -> Option<[f64; LOCALS]> {
    let at = track.place(Sensor::Pose)?;
    let mut poses = window.measured(track, at);
    if poses.any(|(_, pose, _)| pose[2].is_finite()) {
        return None;
    }
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

/// A start by poses that were taken for those of the declared point: by a model that lists where they are mounted, a point
/// elsewhere and another heading.
fn unmounted(near: &[f64; LOCALS], simulated: &Simulated, tracked_ahead_m: f64) -> [f64; LOCALS] {
    let [forward, left, yaw] = simulated.robot.measured_pose([0.0; 3]);
    let (sin, cos) = near[2].sin_cos();
    let seen = [
        near[0] + tracked_ahead_m * cos,
        near[1] + tracked_ahead_m * sin,
    ];
    let heading = near[2] - yaw;
    let (sin, cos) = heading.sin_cos();
    let ahead = tracked_ahead_m + forward;
    let mut start = *near;
    start[0] = seen[0] - ahead * cos + left * sin;
    start[1] = seen[1] - ahead * sin - left * cos;
    start[2] = heading;
    start
}

/// How residuals move with the pose and the angles at the start, as of a rigid body: exact where
/// nothing depends on the place.
fn rigid(
    track: &Track,
    window: &Window,
    start: &[f64; LOCALS],
    residuals: &[f64],
) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; residuals.len()]; LOCALS];
    for (at, series) in track.series.iter().enumerate() {
        for (_, values, base) in window.measured(track, at) {
            let deviation = series.deviation;
            match series.sensor {
                Sensor::WheelAngle => {
                    columns[5][base] = 1.0 / deviation[0];
                    columns[6][base + 1] = 1.0 / deviation[1];
                }
                Sensor::Pose => {
                    let seen = [0, 1].map(|i| values[i] + residuals[base + i] * deviation[i]);
                    columns[0][base] = 1.0 / deviation[0];
                    columns[1][base + 1] = 1.0 / deviation[1];
                    columns[2][base] = -(seen[1] - start[1]) / deviation[0];
                    columns[2][base + 1] = (seen[0] - start[0]) / deviation[1];
                    columns[2][base + 2] = 1.0 / deviation[2];
                }
                _ => {}
            }
        }
    }
    columns.iter_mut().for_each(|column| window.share(column));
    columns
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;
    use slipstream_sim::{Command, Robot};

    use super::{Simulated, Start, unmounted};
    use crate::data::track::Sensor;
    use crate::predict::fixture;

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

    #[test]
    fn a_start_is_that_of_the_robot_wherever_its_camera_is() {
        let offset = [("x_m", -0.03), ("y_m", 0.05), ("yaw_rad", -1.55)];
        let model = RobotModel::default().with("pose_offset", &offset);
        let simulated = Simulated {
            robot: Robot::new(&model).unwrap(),
            step_s: 1e-3,
            bound_to_place: false,
        };
        let place = [0.4, -0.7, 2.1];
        let [x, y, yaw] = simulated.robot.measured_pose(place);
        let start = unmounted(&[x, y, yaw, 0.1, 0.2, 3.0, 4.0], &simulated, 0.0);
        for (own, truth) in start.into_iter().zip([0.4, -0.7, 2.1, 0.1, 0.2, 3.0, 4.0]) {
            assert!((own - truth).abs() < 1e-12, "{start:?}");
        }
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
        let track = fixture::track(vec![(0.0, command)], vec![poses]);
        let predictor = fixture::predictor(track, model);
        let simulated = predictor.simulated(&[]).unwrap();
        let window = &predictor.windows[0];
        let start = Start::guess(
            &simulated,
            &predictor.tracks[0],
            window,
            &predictor.model.robot,
        );
        [start.at[0], start.at[1], start.at[2]]
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
