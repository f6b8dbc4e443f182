//! The encoders count too much or too little.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct EncoderScale<S> {
    right_scale: S,
    left_scale: S,
}

impl<S: Scalar> Effect<S> for EncoderScale<S> {
    const INFO: Info = Info {
        id: "encoder_scale",
        summary: "counts lost or gained in proportion",
        equation: "n = s theta counts / 2 pi",
        source: "plain factor",
        place: Place::Sensor,
        channels: &[Channel::SensorWheels],
        parameters: &[
            ParameterInfo::number("right_scale", "1", 0.5, 2.0, &[0.97, 0.99, 1.01, 1.03]),
            ParameterInfo::number("left_scale", "1", 0.5, 2.0, &[0.97, 0.99, 1.01, 1.03]),
        ],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "always",
        follows: &[],
        experiment: Experiment::HandTurned,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            right_scale: values.number("right_scale"),
            left_scale: values.number("left_scale"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.sensing.encoder_scale = [self.right_scale, self.left_scale];
    }
}
