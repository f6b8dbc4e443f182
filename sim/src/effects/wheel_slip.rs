//! Wheel slip: traction at the driven wheels is limited by Coulomb friction.

use super::info::WHEEL_COMMANDS;
use super::parameter::limit;
use super::{Effect, Info, When, numbers};
use crate::parts::parameters::{Friction, RobotParameters};
use crate::parts::scalar::Scalar;

numbers!(WheelSlip {
    friction_static,
    friction_kinetic
});

impl<S: Scalar> Effect<S> for WheelSlip<S> {
    const INFO: Info = Info::contact(
        "wheel_slip",
        "traction at each driven wheel limited by Coulomb friction, both directions \
            together",
    )
    .equation("|F| <= mu_s N while rolling; F = -mu_k N s / |s| at slip velocity s")
    .source("Konduri, Torres and Pagilla, Eq. 9 and 10")
    .parameters(&[
        limit("friction_static", "1", [1e-3, 10.0], &[0.2]),
        limit("friction_kinetic", "1", [1e-3, 10.0], &[0.2]),
    ])
    .acts(When::Sliding)
    .condition("whenever traction exceeds friction")
    .follows(WHEEL_COMMANDS);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.wheel_friction = Some(Friction {
            friction_static: self.friction_static,
            friction_kinetic: self.friction_kinetic,
        });
    }
}
