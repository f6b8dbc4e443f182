//! Axle friction: Coulomb friction in the wheels' bearings.

use super::parameter::size;
use super::{Effect, Info, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(AxleFriction { torque_nm });

impl<S: Scalar> Effect<S> for AxleFriction<S> {
    const INFO: Info = Info::axle_torque(
        "axle_friction",
        "Coulomb torque against wheel rotation, both wheels alike",
    )
    .equation("tau = -tau_0 sign(omega)")
    .source("Coulomb's law")
    .parameters(&[size(
        "torque_nm",
        "N m",
        [0.0, 100.0],
        &[0.002, 0.006, 0.02],
    )])
    .condition("whenever it moves");

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.axle_torque = Some(self.torque_nm);
    }
}
