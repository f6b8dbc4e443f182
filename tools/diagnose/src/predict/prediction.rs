//! How far a model's predictions go astray, in metres and radians.

use rayon::prelude::*;

use crate::data::faults;
use crate::data::track::{Sensor, Track};
use crate::predict::predictor::Predictor;
use crate::predict::window::{WINDOW_S, Window, cut};
use slipstream_bus::InputError;

use crate::answer::Point;
use crate::request::Request;

/// How one robot of one recording is predicted over windows of 5 s: the start of each is fitted to
/// its first half second, the rest is simulated from what drove the robot. The model is taken as it
/// is; nothing of it is fitted.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// The recording.
    pub recording: String,
    /// The robot.
    pub robot: String,
    /// Root mean square distance from where the robot was seen (m); none without a pose.
    pub position_m: Option<f64>,
    /// Root mean square error of the heading (rad), by the pose or else by the gyro's integral from
    /// the end of the fitted part on; none without both.
    pub heading_rad: Option<f64>,
    /// Error of the heading (rad) over time (s), a gap after each window.
    pub heading: Vec<Point>,
    /// Where the robot was seen (m), a gap after each window.
    pub seen: Vec<Point>,
    /// Where it was predicted (m).
    pub predicted: Vec<Point>,
}

/// A gap between pieces of a line.
const GAP: Point = (f64::NAN, f64::NAN);

/// One window's prediction.
#[derive(Default)]
struct Piece {
    heading: Vec<Point>,
    seen: Vec<Point>,
    predicted: Vec<Point>,
    /// Square distances (m²) and heading errors (rad) behind the fitted part.
    squares_m2: Vec<f64>,
    turned_rad: Vec<f64>,
}

/// Predicts every robot of the recordings by its model.
///
/// # Errors
/// A robot that cannot be predicted, or a model that is none.
pub fn predict(request: &Request<'_>) -> Result<Vec<Prediction>, InputError> {
    let (recordings, _) = faults::mended(request.recordings, request.model_of);
    let mut predictions = Vec::new();
    for recording in recordings.iter() {
        for robot in &recording.robots {
            let predictor = Predictor::new(request, &[(recording, robot)])?;
            let track = &predictor.tracks[0];
            let simulated = predictor.simulated(&[]);
            let windows = cut(track, 0, WINDOW_S);
            let pieces = windows.par_iter().filter_map(|window| {
                let (residuals, fitted_s) = predictor.predicted(simulated.as_ref()?, window)?;
                let from_s = window.from_s + fitted_s;
                Some(piece(track, window, &residuals, from_s))
            });
            let pieces: Vec<Piece> = pieces.collect();
            predictions.push(Prediction::new(&recording.name, &robot.name, &pieces));
        }
    }
    Ok(predictions)
}

impl Prediction {
    fn new(recording: &str, robot: &str, pieces: &[Piece]) -> Self {
        let joined = |own: fn(&Piece) -> &Vec<Point>| {
            let all = pieces.iter().filter(|piece| !own(piece).is_empty());
            all.flat_map(|piece| own(piece).iter().copied().chain([GAP]))
                .collect()
        };
        let distances = pieces.iter().flat_map(|piece| &piece.squares_m2);
        let turns = pieces.iter().flat_map(|piece| &piece.turned_rad);
        Self {
            recording: recording.to_owned(),
            robot: robot.to_owned(),
            position_m: root_mean(distances.copied()),
            heading_rad: root_mean(turns.map(|error| error * error)),
            heading: joined(|piece| &piece.heading),
            seen: joined(|piece| &piece.seen),
            predicted: joined(|piece| &piece.predicted),
        }
    }
}

fn root_mean(squares: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = squares.fold((0.0, 0.0), |(count, sum), square| {
        (count + 1.0, sum + square)
    });
    (count > 0.0).then(|| f64::sqrt(sum / count))
}

/// What residuals (deviations) say in metres and radians; what counts begins at `from_s`.
fn piece(track: &Track, window: &Window, residuals: &[f64], from_s: f64) -> Piece {
    let mut piece = Piece::default();
    if let Some(which) = track.series.iter().position(|s| s.sensor == Sensor::Pose) {
        piece.add_poses(track, window, residuals, which, from_s);
    }
    let gyro = track.series.iter().position(|s| s.sensor == Sensor::Imu);
    if let Some(which) = gyro.filter(|_| piece.heading.is_empty()) {
        piece.add_gyro(track, window, residuals, which, from_s);
    }
    piece
}

impl Piece {
    fn add_poses(
        &mut self,
        track: &Track,
        window: &Window,
        residuals: &[f64],
        which: usize,
        from_s: f64,
    ) {
        let deviation = track.series[which].deviation;
        for (t_s, pose, base) in window.measured(track, which) {
            let error = [0, 1, 2].map(|i| residuals[base + i] * deviation[i]);
            self.seen.push((pose[0], pose[1]));
            let square_m2 = error[0] * error[0] + error[1] * error[1];
            // what a late stamp puts before the window is not simulated
            if square_m2.is_finite() {
                let place = (pose[0] + error[0], pose[1] + error[1]);
                self.predicted.push(place);
            }
            if t_s >= from_s && square_m2.is_finite() {
                self.squares_m2.push(square_m2);
            }
            if t_s >= from_s && error[2].is_finite() {
                self.heading.push((t_s, error[2]));
                self.turned_rad.push(error[2]);
            }
        }
    }

    fn add_gyro(
        &mut self,
        track: &Track,
        window: &Window,
        residuals: &[f64],
        which: usize,
        from_s: f64,
    ) {
        let deviation = track.series[which].deviation[2];
        let mut last: Option<(f64, f64)> = None;
        let mut turned_rad = 0.0;
        for (t_s, _, base) in window.measured(track, which) {
            let rate = residuals[base + 2] * deviation;
            if t_s < from_s || !rate.is_finite() {
                continue;
            }
            if let Some((last_s, last_rate)) = last {
                turned_rad += (t_s - last_s) * (rate + last_rate) / 2.0;
                self.heading.push((t_s, turned_rad));
                self.turned_rad.push(turned_rad);
            }
            last = Some((t_s, rate));
        }
    }
}
