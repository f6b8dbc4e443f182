//! The motors are not as strong as told.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct MotorGain<S> {
    right: S,
    left: S,
}

impl<S: Scalar> Effect<S> for MotorGain<S> {
    const INFO: Info = Info {
        id: "motor_gain",
        summary: "applied torque or speed is a multiple of the commanded one",
        equation: "y = g u",
        source: "plain factor",
        place: Place::Command,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[
            ParameterInfo::number("right", "1", 0.0, 10.0, &[0.85, 0.95, 1.05, 1.15]),
            ParameterInfo::number("left", "1", 0.0, 10.0, &[0.85, 0.95, 1.05, 1.15]),
        ],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "always",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        experiment: Experiment::AddedMass,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            right: values.number("right"),
            left: values.number("left"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.drive.direct = false;
        parts.drive.gain = [self.right, self.left];
    }
}
