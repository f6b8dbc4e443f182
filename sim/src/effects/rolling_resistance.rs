//! Rolling resistance: a force of constant size against the motion.

use super::parameter::size;
use super::{Effect, Info, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(RollingResistance { coefficient });

impl<S: Scalar> Effect<S> for RollingResistance<S> {
    const INFO: Info = Info::drag(
        "rolling_resistance",
        "force of constant size on the body, along its axis, against the motion",
    )
    .equation("F = -c m g sign(u)")
    .source("Coulomb's law; c = force / weight, payload included")
    .parameters(&[size("coefficient", "1", [0.0, 1.0], &[0.003, 0.01, 0.03])]);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.rolling_coefficient = Some(self.coefficient);
    }
}
