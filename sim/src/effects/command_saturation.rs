//! Large commands are cut.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::{Limits, Parts};
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct CommandSaturation<S> {
    torque_nm: Option<S>,
    speed_rad_s: Option<S>,
}

impl<S: Scalar> Effect<S> for CommandSaturation<S> {
    const INFO: Info = Info {
        id: "command_saturation",
        summary: "wheel commands above a size are cut",
        equation: "y = clamp(u, -u_1, u_1)",
        source: "piecewise linear map",
        place: Place::Command,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[
            ParameterInfo::number("torque_nm", "N m", 0.0, 1e3, &[0.04, 0.07, 0.1]).or(),
            ParameterInfo::number("speed_rad_s", "rad/s", 0.0, 1e4, &[1.0, 5.0, 15.0]).or(),
        ],
        repeats: false,
        kinematic: true,
        acts: When::Above,
        condition: "whenever much is commanded",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        experiment: Experiment::Steps,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            torque_nm: values.get("torque_nm"),
            speed_rad_s: values.get("speed_rad_s"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.drive.saturation = Limits {
            torque_nm: self.torque_nm,
            speed_rad_s: self.speed_rad_s,
        };
    }
}
