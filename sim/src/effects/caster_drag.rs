//! Caster drag: Coulomb friction at the caster's contact.

use super::parameter::size;
use super::{Channel, Effect, Info, Manoeuvre, Variable, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(CasterDrag { friction });

impl<S: Scalar> Effect<S> for CasterDrag<S> {
    const INFO: Info = Info::contact(
        "caster_drag",
        "Coulomb friction at the caster's contact, against its velocity",
    )
    .equation("F = -mu N_ca v_ca / |v_ca|")
    .source("Coulomb's law; N_ca from Eq. 6")
    .parameters(&[size("friction", "1", [0.0, 10.0], &[0.02, 0.06, 0.2])])
    .condition("whenever it moves")
    .follows(&[(Channel::Longitudinal, Variable::Speed)])
    .manoeuvre(Manoeuvre::SpinInPlace);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.caster_friction = Some(self.friction);
    }
}
