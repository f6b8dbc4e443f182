//! Torque-speed droop: drive torque falls with wheel speed (back-EMF, viscous bearings).

use super::parameter::size;
use super::{Effect, Info, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(TorqueSpeedDroop { coefficient });

impl<S: Scalar> Effect<S> for TorqueSpeedDroop<S> {
    const INFO: Info = Info::axle_torque(
        "torque_speed_droop",
        "drive torque falls with wheel speed (back-EMF, viscous bearing)",
    )
    .equation("tau = tau_c - k omega")
    .source("DC motor's torque-speed line")
    .parameters(&[size(
        "coefficient",
        "N m s/rad",
        [0.0, 10.0],
        &[5e-4, 2e-3, 8e-3],
    )])
    .condition("the more, the faster the wheels turn");

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.droop += self.coefficient;
    }
}
