//! Normal forces of the driven wheels (Eq. 4 to 6), solved together with the friction forces that
//! depend on them.

use crate::parts::scalar::{Pair, Scalar, clamp};
use crate::robot::Robot;

/// Surge acceleration as an affine function of the normal forces, and what it does to them.
pub(super) struct LoadTransfer<S> {
    /// N_r + N_l per longitudinal acceleration (N s²/m).
    pub(super) transfer: S,
    /// Longitudinal acceleration of c without friction of sliding wheels (m/s²).
    pub(super) free: S,
    /// Longitudinal acceleration per newton of normal force at each wheel (1/kg).
    pub(super) per_normal: Pair<S>,
}

/// N_r and N_l when the lateral force is `lateral` + Σ `per_normal` N, and with load transfer the
/// longitudinal acceleration is affine in N likewise.
#[inline]
pub(super) fn normal_forces<S: Scalar>(
    robot: &Robot<S>,
    lateral: S,
    per_normal: Pair<S>,
    surge: Option<LoadTransfer<S>>,
) -> Pair<S> {
    let zero = S::constant(0.0);
    let half = |[a, b]: Pair<S>| ((a + b) * 0.5, (a - b) * 0.5);
    let (sum, difference) = half(per_normal);
    let height_ratio = robot.load.lateral;
    // N_r − N_l = shift + tilt (N_r + N_l)
    let gain = (S::constant(1.0) - height_ratio * difference).recip();
    let shift = (height_ratio * lateral + robot.load.offset) * gain;
    let tilt = height_ratio * sum * gain;
    let driven = surge.map_or(robot.load.driven, |surge| {
        let (sum, difference) = half(surge.per_normal);
        let rest = robot.load.driven + surge.transfer * (surge.free + difference * shift);
        let whole = rest / (S::constant(1.0) - surge.transfer * (sum + difference * tilt));
        clamp(whole, zero, robot.load.total)
    });
    split_normal(driven, shift + tilt * driven)
}

/// N_r and N_l from their sum and difference. A wheel that would lift off carries nothing.
#[inline]
pub(super) fn split_normal<S: Scalar>(sum: S, difference: S) -> Pair<S> {
    let apart = clamp(difference, -sum, sum);
    [(sum + apart) * 0.5, (sum - apart) * 0.5]
}
