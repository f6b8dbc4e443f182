//! A force in proportion to the square of speed.

use super::{
    Channel, Effect, Experiment, Info, Motion, ParameterInfo, Place, Values, Variable, When, Wrench,
};
use crate::scalar::{Scalar, length};

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct QuadraticDrag<S> {
    coefficient: S,
}

impl<S: Scalar> Effect<S> for QuadraticDrag<S> {
    const INFO: Info = Info {
        id: "quadratic_drag",
        summary: "drag in proportion to the square of the velocity of c",
        equation: "F = -c |v| v",
        source: "Rayleigh's drag equation",
        place: Place::Body,
        channels: &[
            Channel::Longitudinal,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            "coefficient",
            "N s^2/m^2",
            0.0,
            100.0,
            &[0.1, 0.5, 2.0],
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

    fn force(&self, motion: &Motion<S>, wrench: &mut Wrench<S>) {
        let factor = self.coefficient * length(motion.velocity);
        wrench.along -= factor * motion.velocity[0];
        wrench.across -= factor * motion.velocity[1];
    }

    fn has_force(&self) -> bool {
        true
    }
}
