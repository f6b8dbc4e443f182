//! The actuator follows its command gradually.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct ActuatorLag<S> {
    time_constant_s: S,
}

impl<S: Scalar> Effect<S> for ActuatorLag<S> {
    const INFO: Info = Info {
        id: "actuator_lag",
        summary: "first-order lag of the commanded quantity",
        equation: "T dy/dt = u - y",
        source: "first-order system",
        place: Place::Command,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            "time_constant_s",
            "s",
            1e-4,
            10.0,
            &[0.01, 0.03, 0.1],
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
            time_constant_s: values.number("time_constant_s"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.drive.direct = false;
        parts.drive.lag_s = Some(self.time_constant_s);
    }
}
