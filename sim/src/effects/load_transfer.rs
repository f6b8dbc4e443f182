//! Load transfer: longitudinal acceleration shifts load between caster and driven wheels.

use super::parameter::size;
use super::{Channel, Effect, Info, Manoeuvre, Variable, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(LoadTransfer { com_height_m });

impl<S: Scalar> Effect<S> for LoadTransfer<S> {
    const INFO: Info = Info::contact(
        "load_transfer",
        "longitudinal acceleration shifts load between caster and wheels (Eq. 6 leaves it \
            out)",
    )
    .equation("N_ca (d + e) = m_t g d - m_t a h")
    .source("moment balance about the axle's contact line")
    .channels(&[
        Channel::Longitudinal,
        Channel::WheelRight,
        Channel::WheelLeft,
    ])
    .parameters(&[size("com_height_m", "m", [0.0, 1.0], &[0.01, 0.03, 0.08])])
    .follows(&[(Channel::Longitudinal, Variable::Command)])
    .manoeuvre(Manoeuvre::AddedMass);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.transfer_height = Some(self.com_height_m);
    }
}
