//! What predictions look like beside what was measured.

use crate::answer::Point;
use crate::data::track::{CHANNELS, Sensor, Track};
use crate::predict::window::Window;

/// A gap between pieces of a line.
pub(crate) const GAP: Point = (f64::NAN, f64::NAN);

/// Where a robot was seen and where it is predicted (m) at a time (s).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) t_s: f64,
    pub(crate) seen: Point,
    pub(crate) predicted: Point,
}

/// Predictions of one window, or of several.
#[derive(Debug, Clone, Default)]
pub(crate) struct Drawn {
    /// Errors of each channel over time (s), in its unit; places as seen from the robot.
    pub(crate) errors: [Vec<Point>; CHANNELS],
    pub(crate) path: Vec<Place>,
}

impl Drawn {
    /// The prediction of a window with these residuals (deviations).
    pub(crate) fn new(track: &Track, window: &Window, residuals: &[f64]) -> Self {
        let mut drawn = Self::default();
        for (which, series) in track.series.iter().enumerate() {
            let (first, width) = (series.sensor.channel(), series.sensor.width());
            for (t_s, values, base) in window.measured(track, which) {
                let mut error = [f64::NAN; 3];
                for (part, own) in error.iter_mut().enumerate().take(width) {
                    *own = residuals[base + part] * series.deviation[part];
                }
                if series.sensor == Sensor::Pose {
                    drawn.path.push(Place {
                        t_s,
                        seen: (values[0], values[1]),
                        predicted: (values[0] + error[0], values[1] + error[1]),
                    });
                    if values[2].is_finite() {
                        [error[0], error[1]] = from_robot([error[0], error[1]], values[2]);
                    }
                }
                for (line, own) in drawn.errors[first..].iter_mut().zip(error).take(width) {
                    line.push((t_s, own));
                }
            }
        }
        drawn
    }

    /// A gap behind what was drawn up to `t_s`.
    pub(crate) fn gap(&mut self, t_s: f64) {
        self.errors
            .iter_mut()
            .for_each(|line| line.push((t_s, f64::NAN)));
        self.path.push(Place {
            t_s,
            seen: GAP,
            predicted: GAP,
        });
    }

    /// Both, one after the other.
    pub(crate) fn and(mut self, other: Self) -> Self {
        for (line, more) in self.errors.iter_mut().zip(other.errors) {
            line.extend(more);
        }
        self.path.extend(other.path);
        self
    }
}

/// An error of a place as seen from a robot that heads for `yaw_rad`.
pub(crate) fn from_robot([dx, dy]: [f64; 2], yaw_rad: f64) -> [f64; 2] {
    let (sin, cos) = yaw_rad.sin_cos();
    [dx * cos + dy * sin, dy * cos - dx * sin]
}
