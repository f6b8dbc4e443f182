//! Resampling of a column to time windows, block by block. The windows lie between successive edges (s).

/// Longest time over which a value is interpolated or held (s).
const MAX_GAP_S: f64 = 1.0;

/// A time (s) and the value there.
type TimedValue = (f64, f64);

/// Linear interpolation at ascending times; NaN outside the column and in gaps of more than a second.
pub(super) struct Interpolation<'a> {
    at_s: &'a [f64],
    values: Vec<f64>,
    /// The last row of the blocks so far.
    last: Option<TimedValue>,
}

impl<'a> Interpolation<'a> {
    /// Interpolates at these times.
    pub(super) fn new(at_s: &'a [f64]) -> Self {
        Self {
            at_s,
            values: Vec::with_capacity(at_s.len()),
            last: None,
        }
    }

    /// Takes the next rows of the column.
    pub(super) fn push(&mut self, times: &[f64], values: &[f64]) {
        let sample = |i: usize| times.get(i).copied().zip(values.get(i).copied());
        while let Some(t_s) = self.at_s.get(self.values.len()) {
            let after = times.partition_point(|time| time < t_s);
            let Some(next) = sample(after) else {
                break;
            };
            let before = after.checked_sub(1).map_or(self.last, sample);
            self.values.push(interpolate(before, next, *t_s));
        }
        self.last = times.len().checked_sub(1).map_or(self.last, sample);
    }

    /// The values at all times.
    pub(super) fn finish(mut self) -> Vec<f64> {
        self.values.resize(self.at_s.len(), f64::NAN);
        self.values
    }
}

/// The value at `t_s`, which is later than `before` and not later than `next`.
fn interpolate(before: Option<TimedValue>, next: TimedValue, t_s: f64) -> f64 {
    let (t_b, b) = next;
    if t_b == t_s {
        return b;
    }
    match before {
        Some((t_a, a)) if t_b - t_a <= MAX_GAP_S => a + (b - a) * (t_s - t_a) / (t_b - t_a),
        _ => f64::NAN,
    }
}

/// The mean rate of change over each window, from the values at its edges.
pub(super) fn rates(edges: &[f64], at_edges: &[f64]) -> Vec<f64> {
    let rate = |t: &[f64], v: &[f64]| match (t, v) {
        (&[start, end], &[a, b]) => (b - a) / (end - start),
        _ => f64::NAN,
    };
    let pairs = edges.windows(2).zip(at_edges.windows(2));
    pairs.map(|(times, values)| rate(times, values)).collect()
}

/// The mean of the rows in each window. A window without rows gets the last value before it, if that
/// is at most a second old.
pub(super) struct Means<'a> {
    edges: &'a [f64],
    means: Vec<f64>,
    /// Sum and number of the values in the current window so far.
    sum: f64,
    count: usize,
    /// The last row before the current window.
    before: Option<TimedValue>,
    /// The last row of the blocks so far.
    last: Option<TimedValue>,
}

impl<'a> Means<'a> {
    /// Means over the windows between these edges.
    pub(super) fn new(edges: &'a [f64]) -> Self {
        Self {
            edges,
            means: Vec::with_capacity(edges.len()),
            sum: no_sum(),
            count: 0,
            before: None,
            last: None,
        }
    }

    /// Takes the next rows of the column.
    pub(super) fn push(&mut self, times: &[f64], values: &[f64]) {
        let sample = |i: usize| times.get(i).copied().zip(values.get(i).copied());
        while let Some((start, end)) = self.window() {
            let from = times.partition_point(|time| *time < start);
            let to = times.partition_point(|time| *time < end);
            self.before = from.checked_sub(1).map_or(self.before, sample);
            let rows = values.get(from..to).unwrap_or_default();
            for value in rows.iter().filter(|value| !value.is_nan()) {
                self.sum += value;
                self.count += 1;
            }
            if to >= times.len() {
                break;
            }
            self.end_window(start);
            self.before = to.checked_sub(1).map_or(self.last, sample);
        }
        self.last = times.len().checked_sub(1).map_or(self.last, sample);
    }

    /// The means of all windows.
    pub(super) fn finish(mut self) -> Vec<f64> {
        while let Some((start, _)) = self.window() {
            self.end_window(start);
            self.before = self.last;
        }
        self.means
    }

    /// Start and end of the current window.
    fn window(&self) -> Option<(f64, f64)> {
        let at = self.means.len();
        Some((*self.edges.get(at)?, *self.edges.get(at + 1)?))
    }

    fn end_window(&mut self, start: f64) {
        self.means.push(if self.count > 0 {
            self.sum / self.count as f64
        } else {
            let held = self.before.filter(|(time, _)| start - time <= MAX_GAP_S);
            held.map_or(f64::NAN, |(_, value)| value)
        });
        (self.sum, self.count) = (no_sum(), 0);
    }
}

/// What the standard library begins a sum with.
fn no_sum() -> f64 {
    std::iter::empty::<f64>().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows with gaps, repeated times and empty cells.
    fn column() -> (Vec<f64>, Vec<f64>) {
        let times = (0..500).map(|i| f64::from(i / 2 * 2) * 0.03 + f64::from(i / 50) * 0.7);
        let value = |i: i32| match i % 7 {
            3 => f64::NAN,
            _ => (f64::from(i) * 0.37).sin(),
        };
        (times.collect(), (0..500).map(value).collect())
    }

    #[test]
    fn blocks_of_any_size_give_the_same_values() {
        let (times, values) = column();
        let edges: Vec<f64> = (0..60).map(|i| f64::from(i) * 0.5 - 2.0).collect();
        let resampled = |rows: usize| {
            let (mut means, mut at) = (Means::new(&edges), Interpolation::new(&edges));
            for (t_s, v) in times.chunks(rows).zip(values.chunks(rows)) {
                means.push(t_s, v);
                at.push(t_s, v);
            }
            let all = [means.finish(), rates(&edges, &at.finish())].concat();
            all.into_iter().map(f64::to_bits).collect::<Vec<u64>>()
        };
        let whole = resampled(500);
        assert_eq!(whole.len(), 2 * 59);
        for rows in [1, 2, 3, 17, 499] {
            assert_eq!(resampled(rows), whole, "{rows}");
        }
    }

    #[test]
    fn a_window_without_rows_gets_the_last_value_for_a_second() {
        let edges = [-1.0, 0.0, 1.0, 2.0, 3.0, 4.0];
        let mut means = Means::new(&edges);
        means.push(&[0.0, 0.5], &[1.0, 3.0]);
        let means = means.finish();
        assert!(means[0].is_nan());
        assert_eq!(means[1..3], [2.0, 3.0]);
        assert!(means[3..].iter().all(|mean| mean.is_nan()));
    }
}
