//! Actuator lag: a first-order low-pass on the command.

use super::parameter::size;
use super::{Effect, Info, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(ActuatorLag { time_constant_s });

impl<S: Scalar> Effect<S> for ActuatorLag<S> {
    const INFO: Info = Info::command("actuator_lag", "first-order lag of the commanded quantity")
        .equation("T dy/dt = u - y")
        .source("first-order system")
        .parameters(&[size(
            "time_constant_s",
            "s",
            [1e-4, 10.0],
            &[0.01, 0.03, 0.1],
        )])
        .condition("whenever the command changes");

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.direct = false;
        parameters.actuator.lag_s = Some(self.time_constant_s);
    }
}
