//! Encoder scale: the encoders count too much or too little.

use super::parameter::factor;
use super::{Channel, Effect, Info, Manoeuvre, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(EncoderScale {
    right_scale,
    left_scale
});

impl<S: Scalar> Effect<S> for EncoderScale<S> {
    const INFO: Info = Info::sensor(
        "encoder_scale",
        "counts lost or gained in proportion",
        &[Channel::SensorWheels],
    )
    .equation("n = s theta counts / 2 pi")
    .source("plain factor")
    .parameters(&[
        factor("right_scale", [0.0025, 400.0], &[0.97, 0.99, 1.01, 1.03]),
        factor("left_scale", [0.0025, 400.0], &[0.97, 0.99, 1.01, 1.03]),
    ])
    .manoeuvre(Manoeuvre::HandTurned);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.sensing.encoder_scale = [self.right_scale, self.left_scale];
    }
}
