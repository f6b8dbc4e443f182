//! Command saturation: large commands are cut to a limit.

use super::{
    Channel, Effect, FromValues, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Values, Variable,
    When,
};
use crate::parts::actuator::CommandLimits;
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

/// The effect described by its [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct CommandSaturation<S> {
    torque_nm: Option<S>,
    speed_rad_s: Option<S>,
}

impl<S: Scalar> FromValues<S> for CommandSaturation<S> {
    fn from_values(values: &Values<S>) -> Self {
        Self {
            torque_nm: values.get("torque_nm"),
            speed_rad_s: values.get("speed_rad_s"),
        }
    }
}

impl<S: Scalar> Effect<S> for CommandSaturation<S> {
    const INFO: Info = Info {
        id: "command_saturation",
        summary: "wheel commands above a size are cut",
        equation: "y = clamp(u, -u_1, u_1)",
        source: "piecewise linear map",
        site: ModelSite::Command,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[
            ParameterInfo::number(
                Role::Limit,
                "torque_nm",
                "N m",
                0.0,
                1e3,
                &[0.04, 0.07, 0.1],
            )
            .as_alternative(),
            ParameterInfo::number(
                Role::Limit,
                "speed_rad_s",
                "rad/s",
                0.0,
                1e4,
                &[1.0, 5.0, 15.0],
            )
            .as_alternative(),
        ],
        repeats: false,
        kinematic: true,
        acts: When::Above,
        condition: "whenever much is commanded",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        manoeuvre: Manoeuvre::Steps,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.saturation = CommandLimits {
            torque_nm: self.torque_nm,
            voltage_v: None,
            speed_rad_s: self.speed_rad_s,
        };
    }
}
