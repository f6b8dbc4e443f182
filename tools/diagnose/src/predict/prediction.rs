//! How far a model's predictions go astray, in metres and radians.

use rayon::prelude::*;
use slipstream_bus::InputError;

use crate::answer::Point;
use crate::data::faults;
use crate::judge::{GYRO, POSE};
use crate::predict::drawn::{Drawn, GAP};
use crate::predict::predictor::Predictor;
use crate::predict::window::{WINDOW_S, cut};
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

/// One window's prediction, and when (s) the part begins that its start was not fitted to.
struct PredictedWindow {
    drawn: Drawn,
    from_s: f64,
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
                Some(PredictedWindow {
                    drawn: Drawn::new(track, window, &residuals),
                    from_s: window.from_s + fitted_s,
                })
            });
            let pieces: Vec<PredictedWindow> = pieces.collect();
            predictions.push(Prediction::new(&recording.name, &robot.name, &pieces));
        }
    }
    Ok(predictions)
}

impl Prediction {
    fn new(recording: &str, robot: &str, pieces: &[PredictedWindow]) -> Self {
        let headings: Vec<Vec<Point>> = pieces.iter().map(PredictedWindow::heading).collect();
        let turns = headings.iter().flatten().map(|(_, error)| error * error);
        let path = |of: fn(&PredictedWindow) -> Vec<Point>| joined(pieces.iter().map(of));
        Self {
            recording: recording.to_owned(),
            robot: robot.to_owned(),
            position_m: root_mean(pieces.iter().flat_map(PredictedWindow::squares_m2)),
            heading_rad: root_mean(turns),
            seen: path(|own| own.drawn.path.iter().map(|place| place.seen).collect()),
            predicted: path(|own| {
                // what a late stamp puts before the window is not simulated
                let all = own.drawn.path.iter().map(|place| place.predicted);
                all.filter(|(x, y)| x.is_finite() && y.is_finite())
                    .collect()
            }),
            heading: joined(headings.into_iter()),
        }
    }
}

/// Lines one after the other, with gaps between them.
fn joined(lines: impl Iterator<Item = Vec<Point>>) -> Vec<Point> {
    let seen = lines.filter(|line| !line.is_empty());
    seen.flat_map(|line| line.into_iter().chain([GAP]))
        .collect()
}

fn root_mean(squares: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = squares.fold((0.0, 0.0), |(count, sum), square| {
        (count + 1.0, sum + square)
    });
    (count > 0.0).then(|| f64::sqrt(sum / count))
}

impl PredictedWindow {
    /// Errors of a channel behind the fitted part.
    fn errors(&self, channel: usize) -> impl Iterator<Item = Point> {
        let all = self.drawn.errors[channel].iter().copied();
        all.filter(|(t_s, error)| *t_s >= self.from_s && error.is_finite())
    }

    /// Square distances (m²).
    fn squares_m2(&self) -> impl Iterator<Item = f64> {
        let both = self.errors(POSE).zip(self.errors(POSE + 1));
        both.map(|((_, along), (_, across))| along * along + across * across)
    }

    /// Errors of the heading (rad) over time (s): of the pose, or else of the gyro's integral.
    fn heading(&self) -> Vec<Point> {
        let seen: Vec<Point> = self.errors(POSE + 2).collect();
        if !seen.is_empty() {
            return seen;
        }
        let rates: Vec<Point> = self.errors(GYRO).collect();
        let mut turned_rad = 0.0;
        let pairs = rates.windows(2).map(|pair| {
            let [(last_s, last), (t_s, rate)] = [pair[0], pair[1]];
            turned_rad += (t_s - last_s) * (rate + last) / 2.0;
            (t_s, turned_rad)
        });
        pairs.collect()
    }
}
