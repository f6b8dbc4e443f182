//! Motor gain: the motors are stronger or weaker than nominal.

use super::parameter::factor;
use super::{Effect, Info, Manoeuvre, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(MotorGain { right, left });

impl<S: Scalar> Effect<S> for MotorGain<S> {
    const INFO: Info = Info::command(
        "motor_gain",
        "applied torque or speed is a multiple of the commanded one",
    )
    .equation("y = g u")
    .source("plain factor")
    .parameters(&[
        factor("right", [0.0, 10.0], &[0.85, 0.95, 1.05, 1.15]),
        factor("left", [0.0, 10.0], &[0.85, 0.95, 1.05, 1.15]),
    ])
    .manoeuvre(Manoeuvre::AddedMass);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.direct = false;
        parameters.actuator.gain = [self.right, self.left];
    }
}
