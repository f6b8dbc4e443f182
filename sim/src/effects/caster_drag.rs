//! Caster drag: Coulomb friction at the caster's contact.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(CasterDrag { friction });

impl<S: Scalar> Effect<S> for CasterDrag<S> {
    const INFO: Info = Info {
        id: "caster_drag",
        summary: "Coulomb friction at the caster's contact, against its velocity",
        equation: "F = -mu N_ca v_ca / |v_ca|",
        source: "Coulomb's law; N_ca from Eq. 6",
        site: ModelSite::Contact,
        channels: &[
            Channel::Longitudinal,
            Channel::Lateral,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            Role::Size,
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
        manoeuvre: Manoeuvre::SpinInPlace,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.caster_friction = Some(self.friction);
    }
}
