//! Crude factors between two streams of one motion: how far each says that the robot went.
//!
//! Encoders that count four times too much, or in degrees, lie far from any prior, and a search that begins
//! at 1 does not arrive there. Noise and turns in place make these factors crude: they only say where a
//! search begins and how wide its prior has to be, and only beyond what robots have without a mistake.

use super::command_to_wheels::DriveRun;
use super::run::{Run, Source};
use crate::data::wheel_rows::WheelKind;

/// Logarithm of the factor beyond which it counts.
const FAR_LN: f64 = std::f64::consts::LN_2;
/// Steps of the reference over which its noise is small beside its way (s).
const STEP_S: f64 = 0.5;

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
        if let (Source::Measured(path), Some(seen)) = (&run.wheels, pose_way_m(run)) {
            seen_m += seen;
            let pairs = path.angles_rad.windows(2);
            let middle = pairs.map(|p| (p[1][0] - p[0][0] + p[1][1] - p[0][1]).abs() / 2.0);
            rolled_m += wheel_radius_m * middle.sum::<f64>();
        }
    }
    far(seen_m, rolled_m)
}

/// Way of a run's reference (m), in steps that noise hardly lengthens; `None` without one.
fn pose_way_m(run: &Run) -> Option<f64> {
    let rows = &run.pose.as_ref()?.all;
    Some(way_m(rows.iter().map(|(t_s, z)| (*t_s, [z[0], z[1]]))))
}

/// Way of points in steps of half a second (m).
pub(super) fn way_m(points: impl Iterator<Item = (f64, [f64; 2])>) -> f64 {
    let mut last: Option<(f64, [f64; 2])> = None;
    let mut way = 0.0;
    for (t_s, at) in points.filter(|(_, at)| at.iter().all(|x| x.is_finite())) {
        match last {
            Some((before_s, _)) if t_s - before_s < STEP_S => continue,
            Some((_, from)) => way += (at[0] - from[0]).hypot(at[1] - from[1]),
            None => {}
        }
        last = Some((t_s, at));
    }
    way
}

/// Logarithm of what the wheels turned over what they were told; 0 as above.
pub(super) fn gain_ln(runs: &[DriveRun]) -> f64 {
    let (mut turned_rad, mut told_rad) = (0.0, 0.0);
    for run in runs {
        for pair in run.wheels.rows.windows(2) {
            let h = pair[1].time_s - pair[0].time_s;
            let Some(told) = run.commands.at(pair[0].time_s) else {
                continue;
            };
            for (i, told) in told.into_iter().enumerate() {
                told_rad += told.abs() * h;
                turned_rad += match run.wheels.kind {
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

    #[test]
    fn noise_within_half_a_second_is_no_way() {
        let at = |k: u32| (f64::from(k) * 0.1, [f64::from(k % 5), 0.0]);
        assert_eq!(way_m((0..50).map(at)), 0.0);
    }
}
