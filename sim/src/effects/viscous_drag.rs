//! A force in proportion to speed.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct ViscousDrag<S> {
    coefficient: S,
}

impl<S: Scalar> Effect<S> for ViscousDrag<S> {
    const INFO: Info = Info {
        id: "viscous_drag",
        summary: "drag in proportion to the full velocity vector of c",
        equation: "F = -c v",
        source: "Stokes's law of drag",
        place: Place::Body,
        channels: &[
            Channel::Longitudinal,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            "coefficient",
            "N s/m",
            0.0,
            100.0,
            &[0.1, 0.4, 1.5],
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
        parts.drag += self.coefficient;
    }
}
