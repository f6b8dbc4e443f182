//! The turn of a frame in its parent, as a wheel turns: about one axis, while its place stays.

use nalgebra::{UnitQuaternion, Vector3};

use super::rigid::Rigid;
use crate::decode::wrapped;

/// So far (m) the place of a wheel may move in its parent.
const MOST_SHIFT_M: f64 = 1e-3;
/// So much (as a part of half the turn's sine) the axis may differ.
const MOST_TILT: f64 = 0.01;
/// A smaller half turn (sine) does not tell an axis well.
const LEAST_TURN: f64 = 0.05;

/// What was seen of a frame's turn.
#[derive(Debug, Clone, Default)]
pub(super) struct Turned {
    first: Option<Rigid>,
    /// In the frame of the parent.
    axis: Option<Vector3<f64>>,
    /// Whether the place moved, or the axis turned.
    moved: bool,
    /// The last angle about the axis since the first place, and the least and most (rad).
    last_rad: f64,
    span_rad: [f64; 2],
}

impl Turned {
    /// Takes the next place.
    pub(super) fn add(&mut self, place: &Rigid) {
        let first = *self.first.get_or_insert(*place);
        let shift = place.translation.vector - first.translation.vector;
        self.moved |= shift.norm() > MOST_SHIFT_M;
        let turn = (place.rotation * first.rotation.inverse()).into_inner();
        let half = turn.imag();
        let axis = match self.axis {
            Some(axis) => axis,
            None if half.norm() < LEAST_TURN => return,
            None => *self.axis.insert(half.normalize()),
        };
        self.moved |= half.cross(&axis).norm() > MOST_TILT;
        let angle_rad = about(&axis, &first.rotation, &place.rotation);
        self.last_rad += wrapped(angle_rad - self.last_rad);
        let [least, most] = &mut self.span_rad;
        *least = least.min(self.last_rad);
        *most = most.max(self.last_rad);
    }

    /// The axis, in the frame of the parent; `None` unless it was fixed while the frame turned by more than `least_rad`.
    pub(super) fn axis(&self, least_rad: f64) -> Option<Vector3<f64>> {
        let [least, most] = self.span_rad;
        self.axis
            .filter(|_| !self.moved && most - least > least_rad)
    }
}

/// The angle (rad, in [-π, π]) by which a rotation turns about an axis since `first`.
pub(super) fn about(
    axis: &Vector3<f64>,
    first: &UnitQuaternion<f64>,
    rotation: &UnitQuaternion<f64>,
) -> f64 {
    let turn = (rotation * first.inverse()).into_inner();
    wrapped(2.0 * turn.imag().dot(axis).atan2(turn.scalar()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, Unit};

    fn at(x_m: f64, axis: [f64; 3], angle_rad: f64) -> Rigid {
        let axis = Unit::new_normalize(Vector3::from(axis));
        let mount = UnitQuaternion::from_euler_angles(0.5, 0.0, 0.0);
        let turn = UnitQuaternion::from_axis_angle(&axis, angle_rad) * mount;
        Rigid::from_parts(Translation3::new(x_m, 0.2, 0.0), turn)
    }

    fn seen(places: impl Iterator<Item = Rigid>) -> Turned {
        let mut turned = Turned::default();
        places.for_each(|place| turned.add(&place));
        turned
    }

    #[test]
    fn a_wheel_turns_about_one_axis_beyond_half_a_turn() {
        let wheel = seen((0..100).map(|k| at(0.0, [0.0, 1.0, 0.0], 0.3 * f64::from(k))));
        assert!((wheel.axis(6.0).unwrap() - Vector3::y()).norm() < 1e-9);
        assert!((wheel.last_rad - 29.7).abs() < 1e-9, "{}", wheel.last_rad);
        assert!(wheel.axis(30.0).is_none());
    }

    #[test]
    fn what_moves_or_tilts_is_no_wheel() {
        let moves = seen((0..9).map(|k| at(0.01 * f64::from(k), [0.0, 1.0, 0.0], f64::from(k))));
        assert!(moves.axis(1.0).is_none());
        let tilts = seen((0..9).map(|k| at(0.0, [0.1 * f64::from(k), 1.0, 0.0], f64::from(k))));
        assert!(tilts.axis(1.0).is_none());
    }
}
