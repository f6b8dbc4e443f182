//! Backlash: a dead zone between motor and wheel.

use super::parameter::size;
use super::{Effect, Info, When, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(Backlash { gap_rad });

impl<S: Scalar> Effect<S> for Backlash<S> {
    const INFO: Info = Info::transmission(
        "backlash",
        "play between motor and wheel, starting in its middle, contact without \
            rebound; a quarter of I_wy turns with the motor, where the encoder is",
    )
    .equation("tau_wheel = 0 while |theta_m - theta_w| < gap / 2")
    .source("dead zone with inelastic contact")
    .parameters(&[size("gap_rad", "rad", [1e-4, 1.0], &[0.01, 0.03, 0.08])])
    .acts(When::Apart)
    .condition("whenever the drive torque changes sign");

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.gap_rad = Some(self.gap_rad);
    }
}
