//! How well the heading at the start of a window is known where positions alone are seen: from the way over the
//! poses that the start was fitted to.

use crate::data::track::{Sensor, Track};
use crate::predict::window::Window;

/// Variance of a heading of which nothing is known (rad²): that of any angle alike.
const ANY: f64 = std::f64::consts::PI * std::f64::consts::PI / 3.0;
/// Variance of a heading above which it is not known (rad²): that of 18 degrees.
const UNKNOWN: f64 = 0.1;

/// The heading at the start of a window.
pub(super) struct Facing {
    /// The middle of the positions that the start was fitted to (m).
    middle: [f64; 2],
    /// Variance of the heading (rad²); 0 where it was measured.
    variance: f64,
}

impl Facing {
    /// At the start of a window that was fitted to its first `fitted_s` (s) of this series of the track.
    pub(super) fn new(window: &Window, track: &Track, which: usize, fitted_s: f64) -> Self {
        let series = &track.series[which];
        let poses = || {
            window
                .measured(track, which)
                .map(|(t_s, values, _)| (t_s, values))
        };
        let mut own = Self {
            middle: [0.0; 2],
            variance: 0.0,
        };
        if series.sensor != Sensor::Pose || poses().any(|(_, pose)| pose[2].is_finite()) {
            return own;
        }
        let head: Vec<[f64; 3]> = poses()
            .filter(|(t_s, pose)| *t_s < window.from_s + fitted_s && pose[0].is_finite())
            .map(|(_, pose)| pose)
            .collect();
        let count = head.len().max(1) as f64;
        own.middle = [0, 1].map(|i| head.iter().map(|pose| pose[i]).sum::<f64>() / count);
        let squares: f64 = head.iter().map(|pose| own.apart2(*pose)).sum();
        // a robot that stands is seen at places apart by noise as well, up to two deviations of such a sum
        let noise = series.deviation[0].powi(2);
        let way = squares - noise * (2.0 * (count - 1.0) + 4.0 * count.sqrt());
        own.variance = if way > 0.0 {
            (noise / way).min(ANY)
        } else {
            ANY
        };
        own
    }

    /// Whether no prediction from there says anything.
    pub(super) fn is_unknown(&self) -> bool {
        self.variance > UNKNOWN
    }

    /// Square distance from the middle (m²).
    fn apart2(&self, pose: [f64; 3]) -> f64 {
        (pose[0] - self.middle[0]).powi(2) + (pose[1] - self.middle[1]).powi(2)
    }

    /// Variances that an error of the heading adds to a pose.
    pub(super) fn spread(&self, pose: [f64; 3]) -> [f64; 3] {
        let [dx, dy] = [0, 1].map(|i| pose[i] - self.middle[i]);
        [dy * dy, dx * dx, 0.0].map(|square| self.variance * square)
    }
}
