//! Numbers of messages.

/// Infinite numbers mean as little as NaN does: an empty cell.
pub(super) fn finite_or_nan(number: f64) -> f64 {
    if number.is_finite() { number } else { f64::NAN }
}
