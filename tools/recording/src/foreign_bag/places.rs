//! Places of wheels in the base of a robot: their sides, and their axles across it.

use nalgebra::Vector3;

use super::frames::{Frames, Link};
use crate::sides::Side;

/// A wheel lies at least so far (m) beside the middle of the robot.
const LEAST_ASIDE_M: f64 = 0.01;
/// Part of an axle's direction that is across the robot.
const LEAST_ACROSS: f64 = 0.9;
/// The places of a pair mirror each other within this distance (m).
const MIRROR_M: f64 = 0.02;

/// The side of the robot on which a place lies; `None` in the middle.
pub(super) fn side_of_place(place: &Vector3<f64>) -> Option<Side> {
    match place.y {
        y if y > LEAST_ASIDE_M => Some(Side::Left),
        y if y < -LEAST_ASIDE_M => Some(Side::Right),
        _ => None,
    }
}

/// Whether two places mirror each other at the middle of the robot.
pub(super) fn are_mirrored(a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    (a - Vector3::new(b.x, -b.y, b.z)).norm() < MIRROR_M + 0.05 * a.y.abs()
}

/// Whether a frame that turns has its axle across the robot.
pub(super) fn turns_across(frames: &Frames<'_>, link: Link<'_>, least_rad: f64) -> bool {
    let axis = link.seen.turned.axis(least_rad);
    axis.zip(frames.in_base(link))
        .is_some_and(|(axis, own)| (own.parent.rotation * axis).y.abs() > LEAST_ACROSS)
}
