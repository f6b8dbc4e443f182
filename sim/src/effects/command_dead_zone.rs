//! Command dead zone: the command loses a constant size.
//!
//! Its size is counted behind the gain of the motors, so that a changed gain of one wheel stays one change
//! and does not change the loss. Because the gain is a factor, the loss is taken off before saturation and
//! lag, divided by the gain: y = g lag(clamp(D(u))) with D(u) = sign(u) max(|u| - u_0 / g, 0).

use super::{
    Channel, Effect, FromValues, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Values, Variable,
    When,
};
use crate::parts::actuator::CommandLimits;
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

/// The effect described by its [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct CommandDeadZone<S> {
    size: CommandLimits<S>,
}

impl<S: Scalar> FromValues<S> for CommandDeadZone<S> {
    fn from_values(values: &Values<S>) -> Self {
        Self {
            size: CommandLimits {
                torque_nm: values.get("torque_nm"),
                voltage_v: values.get("voltage_v"),
                speed_rad_s: values.get("speed_rad_s"),
            },
        }
    }
}

impl<S: Scalar> Effect<S> for CommandDeadZone<S> {
    const INFO: Info = Info {
        id: "command_dead_zone",
        summary: "the command loses a constant size",
        equation: "y = sign(u) max(|u| - u_0, 0), u the command times the motor gain",
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
            ParameterInfo::number(Role::Size, "voltage_v", "V", 0.0, 1e5, &[0.05, 0.2, 0.8])
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
        acts: When::Always,
        condition: "whenever something is commanded",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        manoeuvre: Manoeuvre::Steps,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.dead_zone = self.size;
    }
}
