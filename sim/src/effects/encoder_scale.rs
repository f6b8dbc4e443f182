//! Encoder scale: the encoders count too much or too little.

use super::{Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, When, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(EncoderScale {
    right_scale,
    left_scale
});

impl<S: Scalar> Effect<S> for EncoderScale<S> {
    const INFO: Info = Info {
        id: "encoder_scale",
        summary: "counts lost or gained in proportion",
        equation: "n = s theta counts / 2 pi",
        source: "plain factor",
        site: ModelSite::Sensor,
        channels: &[Channel::SensorWheels],
        parameters: &[
            ParameterInfo::number(
                Role::Factor,
                "right_scale",
                "1",
                0.0025,
                400.0,
                &[0.97, 0.99, 1.01, 1.03],
            ),
            ParameterInfo::number(
                Role::Factor,
                "left_scale",
                "1",
                0.0025,
                400.0,
                &[0.97, 0.99, 1.01, 1.03],
            ),
        ],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "always",
        follows: &[],
        manoeuvre: Manoeuvre::HandTurned,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.sensing.encoder_scale = [self.right_scale, self.left_scale];
    }
}
