//! Actuator delay: a pure delay of the command.

use super::parameter::size;
use super::{Effect, Info, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(ActuatorDelay { delay_s });

impl<S: Scalar> Effect<S> for ActuatorDelay<S> {
    const INFO: Info = Info::command("actuator_delay", "pure delay of the command")
        .equation("y(t) = u(t - T)")
        .source("pure delay")
        .parameters(&[size("delay_s", "s", [0.0, 1.0], &[0.005, 0.02, 0.06, 0.15])])
        .condition("whenever the command changes");

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.direct = false;
        parameters.actuator.delay_s = Some(self.delay_s);
    }
}
