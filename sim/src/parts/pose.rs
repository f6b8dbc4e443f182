//! Integration of the pose from body-frame velocities, exact for an arc to the fourth order of the
//! turn.

use super::scalar::{Scalar, Vector, heading};

/// The pose [x (m), y (m), φ (rad)] after `over_s` at a body-frame velocity of mean `mean` that
/// changes linearly by `change`.
///
/// The displacement is taken in the frame at half the turn, ∫ R(δ τ) (v + Δv τ) dτ over τ from −½
/// to ½, to the fourth order in the turn δ: an arc of 1 ms is exact to rounding.
#[inline]
pub(crate) fn advance_pose<S: Scalar>(
    pose: [S; 3],
    mean: &Vector<S>,
    change: &Vector<S>,
    over_s: f64,
) -> [S; 3] {
    let turn = mean[2] * over_s;
    let square = turn * turn;
    let chord = (square * (1.0 / 1920.0) - 1.0 / 24.0) * square + 1.0;
    let skew = turn * (1.0 / 12.0);
    let along = mean[0] * chord - change[1] * skew;
    let across = mean[1] * chord + change[0] * skew;
    let [cos, sin] = heading(pose[2] + turn * 0.5);
    [
        pose[0] + (along * cos - across * sin) * over_s,
        pose[1] + (along * sin + across * cos) * over_s,
        pose[2] + turn,
    ]
}
