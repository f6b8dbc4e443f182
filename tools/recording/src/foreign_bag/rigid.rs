//! Places of frames in space: from messages, between two times, in the plane.

use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use slipstream_bag::ros::messages::{self as ros, TransformStamped};

/// A frame in another one (m).
pub(super) type Rigid = Isometry3<f64>;

/// The child of a transform in its parent; `None` if it has no rotation, or values that are no numbers.
pub(super) fn of_message(message: &TransformStamped<String>) -> Option<Rigid> {
    let ros::Quaternion { x, y, z, w } = message.rotation;
    let ros::Vector3 {
        x: x_m,
        y: y_m,
        z: z_m,
    } = message.translation;
    let rotation = Unit::try_new(Quaternion::new(w, x, y, z), 1e-6)?;
    let is_finite = [x, y, z, w, x_m, y_m, z_m]
        .iter()
        .all(|own| own.is_finite());
    is_finite.then(|| Rigid::from_parts(Translation3::new(x_m, y_m, z_m), rotation))
}

/// Between two places, after this share of the way from `a` to `b`. Turn and speed in the frame itself are constant
/// meanwhile: a robot goes along an arc.
pub(super) fn between(a: &Rigid, b: &Rigid, share: f64) -> Rigid {
    let step = a.inverse() * b;
    let half_rad = step.rotation.angle() / 2.0;
    let (along, across) = match step.rotation.axis() {
        None => (step.translation.vector, Vector3::zeros()),
        Some(axis) => {
            let along = axis.into_inner() * axis.dot(&step.translation.vector);
            (along, step.translation.vector - along)
        }
    };
    // The chord of the arc so far, which points less far aside than the whole one.
    let turned =
        UnitQuaternion::from_scaled_axis(step.rotation.scaled_axis() * ((share - 1.0) / 2.0));
    let ratio = match half_rad.sin() {
        0.0 => share,
        whole => (share * half_rad).sin() / whole,
    };
    let offset = along * share + turned * across * ratio;
    let rotation = UnitQuaternion::from_scaled_axis(step.rotation.scaled_axis() * share);
    a * Rigid::from_parts(offset.into(), rotation)
}

/// x (m), y (m) and heading (rad).
pub(super) fn in_plane(place: &Rigid) -> [f64; 3] {
    let Quaternion { coords } = *place.rotation.quaternion();
    let rotation = ros::Quaternion {
        x: coords.x,
        y: coords.y,
        z: coords.z,
        w: coords.w,
    };
    [place.translation.x, place.translation.y, rotation.yaw()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a circle of 2 m around (0, 2).
    fn on_circle(turn_rad: f64) -> Rigid {
        let (sine, cosine) = turn_rad.sin_cos();
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::z() * turn_rad);
        Rigid::from_parts(
            Translation3::new(2.0 * sine, 2.0 - 2.0 * cosine, 0.1),
            rotation,
        )
    }

    #[test]
    fn between_two_places_lies_an_arc() {
        for step_rad in [1e-9, 1e-4, 0.1, 2.0, -1.0] {
            let place = between(&on_circle(0.7), &on_circle(0.7 + step_rad), 0.3);
            let [x, y, yaw] = in_plane(&place);
            let [x_true, y_true, yaw_true] = in_plane(&on_circle(0.7 + 0.3 * step_rad));
            assert!((x - x_true).abs() < 1e-9, "{step_rad}: {x} {x_true}");
            assert!((y - y_true).abs() < 1e-9, "{step_rad}: {y} {y_true}");
            assert!((yaw - yaw_true).abs() < 1e-9, "{step_rad}");
        }
    }

    #[test]
    fn a_straight_step_is_shared_out() {
        let at = |x: f64| Rigid::translation(x, 2.0 * x, 0.0);
        assert!((between(&at(1.0), &at(2.0), 0.25).translation.x - 1.25).abs() < 1e-15);
    }
}
