//! Wheel radius: the wheels are larger or smaller than nominal.

use super::parameter::factor;
use super::{Effect, Info, Manoeuvre, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(WheelRadius {
    right_scale,
    left_scale
});

impl<S: Scalar> Effect<S> for WheelRadius<S> {
    const INFO: Info = Info::transmission("wheel_radius", "radius differs from nominal")
        .equation("r_i = s_i r")
        .source("plain factor")
        .parameters(&[
            factor("right_scale", [0.4, 2.5], &[0.97, 0.99, 1.01, 1.03]),
            factor("left_scale", [0.4, 2.5], &[0.97, 0.99, 1.01, 1.03]),
        ])
        .kinematic()
        .manoeuvre(Manoeuvre::HandTurned);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.radius[0] *= self.right_scale;
        parameters.radius[1] *= self.left_scale;
    }
}
