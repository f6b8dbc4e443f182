//! Wheel radius: the wheels are larger or smaller than nominal.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(WheelRadius {
    right_scale,
    left_scale
});

impl<S: Scalar> Effect<S> for WheelRadius<S> {
    const INFO: Info = Info {
        id: "wheel_radius",
        summary: "radius differs from nominal",
        equation: "r_i = s_i r",
        source: "plain factor",
        site: ModelSite::DriveTrain,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
            Channel::SensorWheels,
        ],
        parameters: &[
            ParameterInfo::number(
                Role::Factor,
                "right_scale",
                "1",
                0.4,
                2.5,
                &[0.97, 0.99, 1.01, 1.03],
            ),
            ParameterInfo::number(
                Role::Factor,
                "left_scale",
                "1",
                0.4,
                2.5,
                &[0.97, 0.99, 1.01, 1.03],
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
        manoeuvre: Manoeuvre::HandTurned,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.radius[0] *= self.right_scale;
        parameters.radius[1] *= self.left_scale;
    }
}
