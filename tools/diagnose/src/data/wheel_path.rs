//! Angles of both wheels over time: measured and interpolated linearly, or simulated.

use slipstream_sim::{Pair, Scalar};

/// Wheel angles, [right, left] (rad), at any time.
pub(crate) trait Turned<S> {
    /// The angles at `time_s`. `hint` is what was found last and makes rising times cheap.
    fn angles_at(&self, time_s: S, hint: &mut usize) -> Pair<S>;
}

/// Measured wheel angles, [right, left] (rad), at rising times (s).
#[derive(Debug, Clone, Default)]
pub(crate) struct WheelPath {
    pub(crate) times_s: Vec<f64>,
    pub(crate) angles_rad: Vec<[f64; 2]>,
}

impl<S: Scalar> Turned<S> for WheelPath {
    /// Before the first and after the last row the wheels stand.
    fn angles_at(&self, time_s: S, hint: &mut usize) -> Pair<S> {
        let t = time_s.value();
        let times = &self.times_s;
        let last = times.len() - 1;
        let constant = |row: usize| self.angles_rad[row].map(S::constant);
        if t <= times[0] {
            return constant(0);
        }
        if t >= times[last] {
            return constant(last);
        }
        let mut row = (*hint).min(last - 1);
        while times[row + 1] < t {
            row += 1;
        }
        while times[row] > t {
            row -= 1;
        }
        *hint = row;
        let span_s = times[row + 1] - times[row];
        let [from, to] = [self.angles_rad[row], self.angles_rad[row + 1]];
        let passed_s = time_s - S::constant(times[row]);
        [0, 1].map(|wheel| passed_s * ((to[wheel] - from[wheel]) / span_s) + from[wheel])
    }
}

impl WheelPath {
    /// Median time between rows (s).
    pub(crate) fn interval_s(&self) -> f64 {
        median_interval(&self.times_s)
    }
}

/// Median time between rows (s); 0 with fewer than two rows.
pub(crate) fn median_interval(times_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}
