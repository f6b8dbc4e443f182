//! Limits of the command: small commands are ignored (dead band), the command loses a constant size (dead
//! zone), large commands are cut (saturation).
//!
//! The size of the dead zone is counted behind the gain of the motors, so that a changed gain of one wheel
//! stays one change and does not change the loss. Because the gain is a factor, the loss is taken off before
//! saturation and lag, divided by the gain: y = g lag(clamp(D(u))) with D(u) = sign(u) max(|u| - u_0 / g, 0).

use super::parameter::{limit, size};
use super::{Effect, FromValues, Info, ParameterInfo, Values, When};
use crate::parts::actuator::CommandLimits;
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

macro_rules! limits {
    ($($name:ident),*) => {$(
        /// The effect described by its [`Effect::INFO`].
        #[derive(Debug, Clone)]
        pub(super) struct $name<S>(CommandLimits<S>);

        impl<S: Scalar> FromValues<S> for $name<S> {
            fn from_values(values: &Values<S>) -> Self {
                Self(CommandLimits {
                    torque_nm: values.get("torque_nm"),
                    voltage_v: values.get("voltage_v"),
                    speed_rad_s: values.get("speed_rad_s"),
                })
            }
        }
    )*};
}

limits!(CommandDeadBand, CommandDeadZone, CommandSaturation);

/// Size of small torques.
const TORQUE: ParameterInfo =
    size("torque_nm", "N m", [0.0, 1e3], &[0.004, 0.012, 0.03]).as_alternative();
/// Size of small speeds.
const SPEED: ParameterInfo =
    size("speed_rad_s", "rad/s", [0.0, 1e4], &[0.05, 0.2, 1.0]).as_alternative();

impl<S: Scalar> Effect<S> for CommandDeadBand<S> {
    const INFO: Info = Info::command(
        "command_dead_band",
        "wheel commands below a size do nothing",
    )
    .equation("y = 0 where |u| < u_0")
    .source("piecewise linear map")
    .parameters(&[TORQUE, SPEED])
    .acts(When::Below)
    .condition("whenever little is commanded");

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.dead_band = self.0;
    }
}

impl<S: Scalar> Effect<S> for CommandDeadZone<S> {
    const INFO: Info = Info::command("command_dead_zone", "the command loses a constant size")
        .equation("y = sign(u) max(|u| - u_0, 0), u the command times the motor gain")
        .source("piecewise linear map")
        .parameters(&[
            TORQUE,
            size("voltage_v", "V", [0.0, 1e5], &[0.05, 0.2, 0.8]).as_alternative(),
            SPEED,
        ])
        .condition("whenever something is commanded");

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.dead_zone = self.0;
    }
}

impl<S: Scalar> Effect<S> for CommandSaturation<S> {
    const INFO: Info = Info::command("command_saturation", "wheel commands above a size are cut")
        .equation("y = clamp(u, -u_1, u_1)")
        .source("piecewise linear map")
        .parameters(&[
            limit("torque_nm", "N m", [0.0, 1e3], &[0.04, 0.07, 0.1]).as_alternative(),
            limit("speed_rad_s", "rad/s", [0.0, 1e4], &[1.0, 5.0, 15.0]).as_alternative(),
        ])
        .acts(When::Above)
        .condition("whenever much is commanded");

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.saturation = self.0;
    }
}
