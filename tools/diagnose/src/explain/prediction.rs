//! Prediction error in the units of the robot: windows of 5 s, the start of each fitted to its first
//! half second, the rest simulated from what drives the robot, the commands or else the wheels.

use super::errors::Errors;
use super::fitted_noise::NoiseOf;
use super::open_loop::HORIZON_S;
use crate::data::streams::WheelKind;
use crate::data::wheel_path::Turned;
use crate::judge::{GYRO, HEADING, PLACE, POSE, QUANTITIES};
use crate::model::command_to_wheels::DriveRun;
use crate::model::drive::{AVERAGED, Response};
use crate::model::from_wheels::FromWheels;
use crate::model::run::{Run, sensor_noise};
use crate::model::wheel_parameters::drive_parameters;
use crate::predict::window::at_most;

/// Time over which the start of a window is fitted (s).
pub(super) const FITTED_S: f64 = 0.5;
/// Shortest window (s).
pub(crate) const SHORTEST_S: f64 = 1.0;
/// Most rows of a sensor that are predicted.
const MOST_ROWS: usize = 5000;
/// Most windows of a run by which two models are compared.
const MOST_WINDOWS: usize = 40;
/// Rows of a window that are predicted however long the recording is.
const LEAST_ROWS: usize = 50;

/// What a run is predicted by.
pub(crate) struct Predictor<'a> {
    pub(crate) machine: &'a FromWheels,
    pub(crate) run: &'a Run,
    /// Commands and wheels, where both were recorded.
    pub(crate) drive: Option<&'a DriveRun>,
    /// Standard deviations of the sensors, channel by channel.
    pub(crate) deviations: [f64; QUANTITIES],
    /// Noise sizes by which the error is predicted; without them that of the sensors alone is.
    pub(crate) noise: Option<Noise<'a>>,
}

/// Fitted noise sizes of a run.
#[derive(Clone, Copy)]
pub(crate) struct Noise<'a> {
    /// All parameters of the machine as they were fitted.
    pub(crate) at: &'a [f64],
    /// Logarithms of the noise sizes of the drive.
    pub(crate) drive: Option<&'a [f64]>,
}

/// One window of a run, with what it is predicted by.
pub(super) struct Piece<'a> {
    pub(super) own: &'a Predictor<'a>,
    /// Parameters of the run.
    pub(super) local: &'a [f64],
    pub(super) noise: &'a NoiseOf,
    pub(super) wheels: &'a dyn Turned<f64>,
    /// Begin and end (s).
    pub(super) span_s: [f64; 2],
}

impl Predictor<'_> {
    /// Begin and end of the windows (s).
    pub(crate) fn windows(&self) -> Vec<[f64; 2]> {
        let [from_s, to_s] = self.run.blocks.span_s;
        let count = ((to_s - from_s) / HORIZON_S).ceil().max(1.0) as usize;
        let all = (0..count).map(|k| {
            let begin = from_s + HORIZON_S * k as f64;
            [begin, (begin + HORIZON_S).min(to_s)]
        });
        all.filter(|[a, b]| b - a >= SHORTEST_S).collect()
    }

    /// Whether wheels that are predicted are measured by angles.
    pub(crate) fn has_angles(&self) -> bool {
        let kind = self.drive.map(|drive| drive.wheels.kind);
        kind.is_none_or(|kind| kind == WheelKind::Angle)
    }

    /// Predicts these windows by the parameters `at` of the machine, of run number `number`.
    pub(crate) fn errors(&self, number: usize, at: &[f64], windows: &[[f64; 2]]) -> Errors {
        let local = self.machine.local(number, at);
        let noise = self.noise.map(|noise| {
            let local = self.machine.local(number, noise.at);
            let turn_per_wheel = self.machine.wheel_radius_m / self.machine.half_track_m;
            NoiseOf::new(self.run, &local, noise.drive, turn_per_wheel)
        });
        let noise = noise.unwrap_or_default();
        let each = |wheels: &dyn Turned<f64>| {
            let one = |span_s: &[f64; 2]| {
                let piece = Piece {
                    own: self,
                    local: &local,
                    noise: &noise,
                    wheels,
                    span_s: *span_s,
                };
                let mut errors = Errors::default();
                piece.poses(&mut errors);
                piece.rates(&mut errors);
                errors
            };
            windows.iter().map(one).collect::<Vec<Errors>>()
        };
        let mut each = match self.drive {
            None => self.run.wheels.turned(drive_parameters(&local), each),
            Some(drive) => {
                let response = Response::new(&drive.commands, drive_parameters(&local));
                let over_s = drive_parameters(&local)[AVERAGED];
                let mut each = each(&response);
                for (window, errors) in windows.iter().zip(&mut each) {
                    self.wheels(drive, &noise, (&response, over_s), *window, errors);
                }
                each
            }
        };
        for (window, errors) in windows.iter().zip(&mut each) {
            errors.drawn.gap(window[1]);
            errors.windows = vec![(*window, errors.score)];
        }
        each.into_iter().fold(Errors::default(), Errors::and)
    }
}

/// At most so many windows, at equal distances.
pub(super) fn some_windows(predictor: &Predictor<'_>, most: usize) -> Vec<[f64; 2]> {
    at_most(&predictor.windows(), most)
}

/// The rows of a window (s), or some of them where the recording has very many.
pub(super) fn rows_of<T>(
    rows: &[(f64, T)],
    [from_s, to_s]: [f64; 2],
) -> impl Iterator<Item = &(f64, T)> {
    let [first, end] = [from_s, to_s].map(|t_s| rows.partition_point(|row| row.0 < t_s));
    let stride = stride(rows.len(), end - first);
    rows[first..end].iter().step_by(stride)
}

/// Error of predictions by the wheels of a machine with these parameters: geometric mean of place (m) and
/// heading (rad), of those that are seen.
pub(super) fn reference_error(machine: &FromWheels, at: &[f64]) -> f64 {
    let today = machine.runs.iter().enumerate().skip(machine.before.runs);
    let all = today.map(|(number, run)| {
        let predictor = Predictor {
            machine,
            run,
            drive: None,
            deviations: [1.0; QUANTITIES],
            noise: None,
        };
        predictor.errors(number, at, &some_windows(&predictor, MOST_WINDOWS))
    });
    let sum = all.fold(Errors::default(), Errors::and);
    let [place, heading] = [PLACE, HEADING].map(|quantity| sum.score.mean_square(quantity));
    match (place, heading) {
        (Some(place), Some(heading)) => (place * heading).powf(0.25),
        (Some(one), None) | (None, Some(one)) => one.sqrt(),
        (None, None) => 0.0,
    }
}

/// Standard deviations of the sensors of a run, channel by channel.
pub(crate) fn deviations(
    run: &Run,
    drive: Option<&DriveRun>,
    declared: &slipstream_recording::recording::Noise,
) -> [f64; QUANTITIES] {
    let [place, yaw] = run.pose.as_ref().map_or([1.0; 2], |p| sensor_noise(&p.all));
    let wheels = drive.map_or(1.0, |drive| {
        drive
            .wheels
            .rounding_rad
            .max(declared.wheel_rad.unwrap_or(1e-4))
    });
    let place = declared.pose_m.unwrap_or(place);
    let yaw = declared.pose_rad.unwrap_or(yaw);
    let gyro = declared.imu_rad_s.unwrap_or_else(|| {
        let rows = run.gyro.as_ref().map_or(&[][..], |gyro| &gyro.all);
        let mut steps: Vec<f64> = rows.windows(2).map(|w| (w[1].1 - w[0].1).abs()).collect();
        steps.sort_by(f64::total_cmp);
        let median = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
        (median / 0.67 / 2.0_f64.sqrt()).max(1e-4)
    });
    let mut all = [1.0; QUANTITIES];
    all[..POSE].fill(wheels);
    all[POSE..=POSE + 1].fill(place);
    all[POSE + 2] = yaw;
    all[GYRO] = gyro;
    all
}

/// Decimation factor of the `window` rows of a window that is predicted, of `all` rows of the recording.
fn stride(all: usize, window: usize) -> usize {
    let wanted = all.div_ceil(MOST_ROWS);
    wanted.min(window / LEAST_ROWS).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_of_a_long_recording_keeps_its_rows() {
        assert_eq!(stride(900, 150), 1);
        assert_eq!(stride(108_002, 150), 3);
        assert_eq!(stride(3_600_000, 5000), 100);
        assert_eq!(stride(3_600_000, 20), 1);
    }
}
