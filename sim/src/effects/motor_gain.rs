//! Motor gain: the motors are stronger or weaker than nominal.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(MotorGain { right, left });

impl<S: Scalar> Effect<S> for MotorGain<S> {
    const INFO: Info = Info {
        id: "motor_gain",
        summary: "applied torque or speed is a multiple of the commanded one",
        equation: "y = g u",
        source: "plain factor",
        site: ModelSite::Command,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[
            ParameterInfo::number(
                Role::Factor,
                "right",
                "1",
                0.0,
                10.0,
                &[0.85, 0.95, 1.05, 1.15],
            ),
            ParameterInfo::number(
                Role::Factor,
                "left",
                "1",
                0.0,
                10.0,
                &[0.85, 0.95, 1.05, 1.15],
            ),
        ],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "always",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        manoeuvre: Manoeuvre::AddedMass,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.direct = false;
        parameters.actuator.gain = [self.right, self.left];
    }
}
