//! Actuator delay: a pure delay of the command.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(ActuatorDelay { delay_s });

impl<S: Scalar> Effect<S> for ActuatorDelay<S> {
    const INFO: Info = Info {
        id: "actuator_delay",
        summary: "pure delay of the command",
        equation: "y(t) = u(t - T)",
        source: "pure delay",
        site: ModelSite::Command,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            Role::Size,
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
        manoeuvre: Manoeuvre::Steps,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.direct = false;
        parameters.actuator.delay_s = Some(self.delay_s);
    }
}
