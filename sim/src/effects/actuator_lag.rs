//! Actuator lag: a first-order low-pass on the command.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(ActuatorLag { time_constant_s });

impl<S: Scalar> Effect<S> for ActuatorLag<S> {
    const INFO: Info = Info {
        id: "actuator_lag",
        summary: "first-order lag of the commanded quantity",
        equation: "T dy/dt = u - y",
        source: "first-order system",
        site: ModelSite::Command,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            Role::Size,
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
        manoeuvre: Manoeuvre::Steps,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.direct = false;
        parameters.actuator.lag_s = Some(self.time_constant_s);
    }
}
