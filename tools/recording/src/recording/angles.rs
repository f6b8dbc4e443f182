//! Phase unwrapping.

use std::f64::consts::TAU;

/// Removes jumps of whole turns from a sequence of angles (rad), one by one. NaN (an empty cell) stays
/// NaN.
#[derive(Debug)]
pub(crate) struct Unwrap {
    last: f64,
    turns: f64,
}

impl Default for Unwrap {
    fn default() -> Self {
        Self {
            last: f64::NAN,
            turns: 0.0,
        }
    }
}

impl Unwrap {
    /// The next angle (rad) without jumps.
    pub(crate) fn next(&mut self, angle_rad: f64) -> f64 {
        if angle_rad.is_nan() {
            return f64::NAN;
        }
        if !self.last.is_nan() {
            self.turns -= ((angle_rad - self.last) / TAU).round();
        }
        self.last = angle_rad;
        angle_rad + self.turns * TAU
    }
}

/// Removes jumps of whole turns from a sequence of angles (rad).
pub(crate) fn unwrap_angles(angles_rad: &[f64]) -> Vec<f64> {
    let mut unwrap = Unwrap::default();
    angles_rad.iter().map(|angle| unwrap.next(*angle)).collect()
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
