//! Command dead band: small commands are ignored.

use super::{
    Channel, Effect, FromValues, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Values, Variable,
    When,
};
use crate::parts::actuator::CommandLimits;
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

/// The effect described by its [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct CommandDeadBand<S> {
    torque_nm: Option<S>,
    speed_rad_s: Option<S>,
}

impl<S: Scalar> FromValues<S> for CommandDeadBand<S> {
    fn from_values(values: &Values<S>) -> Self {
        Self {
            torque_nm: values.get("torque_nm"),
            speed_rad_s: values.get("speed_rad_s"),
        }
    }
}

impl<S: Scalar> Effect<S> for CommandDeadBand<S> {
    const INFO: Info = Info {
        id: "command_dead_band",
        summary: "wheel commands below a size do nothing",
        equation: "y = 0 where |u| < u_0",
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
                Role::Size,
                "torque_nm",
                "N m",
                0.0,
                1e3,
                &[0.004, 0.012, 0.03],
            )
            .as_alternative(),
            ParameterInfo::number(
                Role::Size,
                "speed_rad_s",
                "rad/s",
                0.0,
                1e4,
                &[0.05, 0.2, 1.0],
            )
            .as_alternative(),
        ],
        repeats: false,
        kinematic: true,
        acts: When::Below,
        condition: "whenever little is commanded",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        manoeuvre: Manoeuvre::Steps,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.dead_band = CommandLimits {
            torque_nm: self.torque_nm,
            voltage_v: None,
            speed_rad_s: self.speed_rad_s,
        };
    }
}
