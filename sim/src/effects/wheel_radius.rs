//! The wheels are larger or smaller than told.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct WheelRadius<S> {
    right_scale: S,
    left_scale: S,
}

impl<S: Scalar> Effect<S> for WheelRadius<S> {
    const INFO: Info = Info {
        id: "wheel_radius",
        summary: "radius differs from nominal",
        equation: "r_i = s_i r",
        source: "plain factor",
        place: Place::DriveTrain,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
            Channel::SensorWheels,
        ],
        parameters: &[
            ParameterInfo::number("right_scale", "1", 0.5, 2.0, &[0.97, 0.99, 1.01, 1.03]),
            ParameterInfo::number("left_scale", "1", 0.5, 2.0, &[0.97, 0.99, 1.01, 1.03]),
        ],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "always",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        experiment: Experiment::HandTurned,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            right_scale: values.number("right_scale"),
            left_scale: values.number("left_scale"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.radius[0] *= self.right_scale;
        parts.radius[1] *= self.left_scale;
    }
}
