//! Phase unwrapping of angles.

use std::f64::consts::TAU;

/// The heading without jumps of a whole turn. Empty cells stay empty.
pub(crate) fn unwrap(yaw: &[f64]) -> Vec<f64> {
    let mut last = f64::NAN;
    let mut turns = 0.0;
    yaw.iter()
        .map(|yaw| {
            if yaw.is_nan() {
                return f64::NAN;
            }
            if !last.is_nan() {
                turns -= ((yaw - last) / TAU).round();
            }
            last = *yaw;
            yaw + turns * TAU
        })
        .collect()
}
