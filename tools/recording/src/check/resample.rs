//! Resampling of a column to time windows. The windows lie between successive `edges` (s).

/// Longest time over which a value is interpolated or held (s).
const MAX_GAP_S: f64 = 1.0;

/// Linear interpolation at `t_s`; NaN outside the column and in gaps of more than a second.
pub(super) fn interpolate(times: &[f64], values: &[f64], t_s: f64) -> f64 {
    let after = times.partition_point(|time| *time < t_s);
    let sample = |i: usize| times.get(i).copied().zip(values.get(i).copied());
    let Some((t_b, b)) = sample(after) else {
        return f64::NAN;
    };
    if t_b == t_s {
        return b;
    }
    match after.checked_sub(1).and_then(sample) {
        Some((t_a, a)) if t_b - t_a <= MAX_GAP_S => a + (b - a) * (t_s - t_a) / (t_b - t_a),
        _ => f64::NAN,
    }
}

/// The mean rate of change over each window.
pub(super) fn rates(times: &[f64], values: &[f64], edges: &[f64]) -> Vec<f64> {
    let windows = edges.iter().zip(edges.iter().skip(1));
    let value = |t_s: f64| interpolate(times, values, t_s);
    windows
        .map(|(start, end)| (value(*end) - value(*start)) / (end - start))
        .collect()
}

/// The mean of the rows in each window. A window without rows gets the last value before it, if that
/// is at most a second old.
pub(super) fn means(times: &[f64], values: &[f64], edges: &[f64]) -> Vec<f64> {
    let windows = edges.iter().zip(edges.iter().skip(1));
    windows
        .map(|(start, end)| {
            let from = times.partition_point(|time| time < start);
            let to = times.partition_point(|time| time < end);
            let rows = values.get(from..to).unwrap_or_default();
            let rows: Vec<f64> = rows.iter().copied().filter(|v| !v.is_nan()).collect();
            if !rows.is_empty() {
                return rows.iter().sum::<f64>() / rows.len() as f64;
            }
            let before = from.checked_sub(1);
            let held = before.and_then(|i| times.get(i).zip(values.get(i)));
            held.filter(|(time, _)| start - **time <= MAX_GAP_S)
                .map_or(f64::NAN, |(_, value)| *value)
        })
        .collect()
}
