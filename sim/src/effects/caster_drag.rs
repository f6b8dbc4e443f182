//! The caster rubs.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct CasterDrag<S> {
    friction: S,
}

impl<S: Scalar> Effect<S> for CasterDrag<S> {
    const INFO: Info = Info {
        id: "caster_drag",
        summary: "Coulomb friction at the caster's contact, against its velocity",
        equation: "F = -mu N_ca v_ca / |v_ca|",
        source: "Coulomb's law; N_ca from Eq. 6",
        place: Place::Contact,
        channels: &[
            Channel::Longitudinal,
            Channel::Lateral,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            "friction",
            "1",
            0.0,
            10.0,
            &[0.02, 0.06, 0.2],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "whenever it moves",
        follows: &[(Channel::Longitudinal, Variable::Speed)],
        experiment: Experiment::SpinInPlace,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            friction: values.number("friction"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.caster_friction = Some(self.friction);
    }
}
