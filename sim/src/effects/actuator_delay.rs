//! The actuator acts late.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct ActuatorDelay<S> {
    delay_s: S,
}

impl<S: Scalar> Effect<S> for ActuatorDelay<S> {
    const INFO: Info = Info {
        id: "actuator_delay",
        summary: "pure delay of the command",
        equation: "y(t) = u(t - T)",
        source: "pure delay",
        place: Place::Command,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            "delay_s",
            "s",
            0.0,
            1.0,
            &[0.005, 0.02, 0.06, 0.15],
        )],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "whenever the command changes",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        experiment: Experiment::Steps,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            delay_s: values.number("delay_s"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.drive.direct = false;
        parts.drive.delay_s = Some(self.delay_s);
    }
}
