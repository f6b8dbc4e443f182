//! Viscous drag: a force in proportion to speed.

use super::parameter::size;
use super::{Effect, Info, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(ViscousDrag { coefficient });

impl<S: Scalar> Effect<S> for ViscousDrag<S> {
    const INFO: Info = Info::drag(
        "viscous_drag",
        "drag in proportion to the full velocity vector of c",
    )
    .equation("F = -c v")
    .source("Stokes's law of drag")
    .parameters(&[size("coefficient", "N s/m", [0.0, 100.0], &[0.1, 0.4, 1.5])]);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.drag += self.coefficient;
    }
}
