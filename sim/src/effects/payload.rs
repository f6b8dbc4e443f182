//! Payload: an additional point mass on the robot.

use super::parameter::{Role, number, position};
use super::{Channel, Effect, Info, Manoeuvre, Variable, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(Payload { mass_kg, x_m, y_m });

impl<S: Scalar> Effect<S> for Payload<S> {
    const INFO: Info = Info::body(
        "payload",
        "point mass at a place from c, body frame (pose stays at the body's own c)",
        Manoeuvre::AddedMass,
    )
    .equation("N_ca = (m_t g d + m_p g (d + x)) / (d + e); N_r - N_l = (F_lat h - m_p g y) / b")
    .source("moment balances of Eq. 5 and 6 with one mass more")
    .parameters(&[
        number(Role::Mass, "mass_kg", "kg", [0.0, 1e3], &[0.05, 0.15, 0.4]),
        position("x_m", 10.0, &[-0.04, 0.0, 0.04]),
        position("y_m", 10.0, &[-0.04, 0.0, 0.04]),
    ])
    .repeats()
    .follows(&[
        (Channel::Longitudinal, Variable::Command),
        (Channel::Yaw, Variable::Command),
    ]);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        let (m, x, y) = (self.mass_kg, self.x_m, self.y_m);
        parameters.payload_mass += m;
        parameters.payload_moment[0] += m * x;
        parameters.payload_moment[1] += m * y;
        parameters.payload_inertia += m * (x * x + y * y);
    }
}
