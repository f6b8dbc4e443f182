//! A force of constant size against the motion.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct RollingResistance<S> {
    coefficient: S,
}

impl<S: Scalar> Effect<S> for RollingResistance<S> {
    const INFO: Info = Info {
        id: "rolling_resistance",
        summary: "force of constant size on the body, along its axis, against the motion",
        equation: "F = -c m g sign(u)",
        source: "Coulomb's law; c = force / weight, payload included",
        place: Place::Body,
        channels: &[
            Channel::Longitudinal,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            "coefficient",
            "1",
            0.0,
            1.0,
            &[0.003, 0.01, 0.03],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "whenever it moves",
        follows: &[(Channel::Longitudinal, Variable::Speed)],
        experiment: Experiment::CoastDown,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            coefficient: values.number("coefficient"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.rolling_coefficient = Some(self.coefficient);
    }
}
