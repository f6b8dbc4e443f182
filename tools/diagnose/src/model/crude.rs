//! Crude factors between two streams of one motion: how far each says that the robot went.
//!
//! Encoders that count four times too much, or in degrees, lie far from any prior, and a search that begins
//! at 1 does not arrive there. Noise and turns in place make these factors crude: they only say where a
//! search begins and how wide its prior has to be, and only beyond what robots have without a mistake.

use super::run::{Run, Source};
use crate::data::command::CommandPath;
use crate::data::reference::seen_way_m;
use crate::data::streams::WheelKind;
use crate::data::wheel_rows::WheelRows;

/// Logarithm of the factor beyond which it counts.
const FAR_LN: f64 = std::f64::consts::LN_2;
/// A logarithm of a factor, or 0 where it is nothing beyond the usual or not known.
fn far(numerator: f64, denominator: f64) -> f64 {
    let ln = (numerator / denominator).ln();
    if ln.is_finite() && ln.abs() > FAR_LN {
        ln
    } else {
        0.0
    }
}

/// Logarithm of the way (m) of the reference over that of the middle of both wheels (rad) times a radius; 0
/// where it is below a factor of 2, or nothing is known.
pub(super) fn scale_ln(runs: &[Run], wheel_radius_m: f64) -> f64 {
    let (mut seen_m, mut rolled_m) = (0.0, 0.0);
    for run in runs {
        if let (Source::Measured(path), Some(pose)) = (&run.wheels, &run.pose) {
            seen_m += seen_way_m(&pose.all);
            let pairs = path.angles_rad.windows(2);
            let middle = pairs.map(|p| (p[1][0] - p[0][0] + p[1][1] - p[0][1]).abs() / 2.0);
            rolled_m += wheel_radius_m * middle.sum::<f64>();
        }
    }
    far(seen_m, rolled_m)
}

/// Logarithm of what the wheels turned over what they were told; 0 as above.
pub(super) fn gain_ln<'a>(runs: impl Iterator<Item = (&'a CommandPath, &'a WheelRows)>) -> f64 {
    let (mut turned_rad, mut told_rad) = (0.0, 0.0);
    for (commands, wheels) in runs {
        for pair in wheels.rows.windows(2) {
            let h = pair[1].time_s - pair[0].time_s;
            let Some(told) = commands.at(pair[0].time_s) else {
                continue;
            };
            for (i, told) in told.into_iter().enumerate() {
                told_rad += told.abs() * h;
                turned_rad += match wheels.kind {
                    WheelKind::Angle => (pair[1].values[i] - pair[0].values[i]).abs(),
                    WheelKind::Speed => pair[0].values[i].abs() * h,
                };
            }
        }
    }
    far(turned_rad, told_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_factors_beyond_two_count() {
        assert!((far(8.0, 2.0) - 4.0_f64.ln()).abs() < 1e-12);
        assert_eq!([far(3.0, 2.0), far(1.0, 0.0), far(0.0, 1.0)], [0.0; 3]);
    }
}
