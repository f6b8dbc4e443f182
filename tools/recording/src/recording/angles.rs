//! Phase unwrapping.

use std::f64::consts::TAU;

/// Removes jumps of whole turns from a sequence of angles (rad). NaN (an empty cell) stays NaN.
pub(crate) fn unwrap_angles(angles_rad: &[f64]) -> Vec<f64> {
    let mut last = f64::NAN;
    let mut turns = 0.0;
    angles_rad
        .iter()
        .map(|angle| {
            if angle.is_nan() {
                return f64::NAN;
            }
            if !last.is_nan() {
                turns -= ((angle - last) / TAU).round();
            }
            last = *angle;
            angle + turns * TAU
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unwraps_across_empty_cells() {
        let wrapped = [3.0, f64::NAN, 3.5 - TAU, 2.9];
        let unwrapped = unwrap_angles(&wrapped);
        assert!(unwrapped[1].is_nan());
        assert!((unwrapped[2] - 3.5).abs() < 1e-12 && (unwrapped[3] - 2.9).abs() < 1e-12);
    }
}
