//! Supply sag: drive strength falls as the battery runs down.

use super::parameter::size;
use super::{Effect, Info, Manoeuvre, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(SupplySag { rate_per_s });

impl<S: Scalar> Effect<S> for SupplySag<S> {
    const INFO: Info = Info::command(
        "supply_sag",
        "drive strength falls in proportion to time from the recording's start",
    )
    .equation("y = u (1 - k t)")
    .source("first order in time of a falling supply")
    .parameters(&[size(
        "rate_per_s",
        "1/s",
        [-0.1, 0.1],
        &[-0.002, 0.002, 0.008],
    )])
    .manoeuvre(Manoeuvre::SameAgain);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.direct = false;
        parameters.actuator.sag_per_s = self.rate_per_s;
    }
}
