//! A stream window by window.

/// A straight line between the samples around `t_s`; NaN outside, and across pauses of a second.
pub(super) fn at(times: &[f64], values: &[f64], t_s: f64) -> f64 {
    let after = times.partition_point(|time| *time < t_s);
    let sample = |i: usize| times.get(i).copied().zip(values.get(i).copied());
    let Some((t_b, b)) = sample(after) else {
        return f64::NAN;
    };
    if t_b == t_s {
        return b;
    }
    match after.checked_sub(1).and_then(sample) {
        Some((t_a, a)) if t_b - t_a <= 1.0 => a + (b - a) * (t_s - t_a) / (t_b - t_a),
        _ => f64::NAN,
    }
}

/// The rate of change over each window.
pub(super) fn rates(times: &[f64], values: &[f64], edges: &[f64]) -> Vec<f64> {
    let pairs = edges.iter().zip(edges.iter().skip(1));
    pairs
        .map(|(a, b)| (at(times, values, *b) - at(times, values, *a)) / (b - a))
        .collect()
}

/// The mean of the rows in each window; without rows what holds from before, if not over a second
/// old.
pub(super) fn means(times: &[f64], values: &[f64], edges: &[f64]) -> Vec<f64> {
    let pairs = edges.iter().zip(edges.iter().skip(1));
    pairs
        .map(|(a, b)| {
            let from = times.partition_point(|time| time < a);
            let to = times.partition_point(|time| time < b);
            let rows = values.get(from..to).unwrap_or_default();
            let seen: Vec<f64> = rows.iter().copied().filter(|v| !v.is_nan()).collect();
            if !seen.is_empty() {
                return seen.iter().sum::<f64>() / seen.len() as f64;
            }
            let before = from.checked_sub(1);
            let held = before.and_then(|i| times.get(i).zip(values.get(i)));
            held.filter(|(time, _)| a - **time <= 1.0)
                .map_or(f64::NAN, |(_, value)| *value)
        })
        .collect()
}
