//! Something lies on the robot.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct Payload<S> {
    mass_kg: S,
    x_m: S,
    y_m: S,
}

impl<S: Scalar> Effect<S> for Payload<S> {
    const INFO: Info = Info {
        id: "payload",
        summary: "point mass at a place from c, body frame (pose stays at the body's own c)",
        equation: "N_ca = (m_t g d + m_p g (d + x)) / (d + e); N_r - N_l = (F_lat h - m_p g y) / b",
        source: "moment balances of Eq. 5 and 6 with one mass more",
        place: Place::Body,
        channels: &[Channel::Longitudinal, Channel::Lateral, Channel::Yaw],
        parameters: &[
            ParameterInfo::number("mass_kg", "kg", 0.0, 1e3, &[0.05, 0.15, 0.4]),
            ParameterInfo::number("x_m", "m", -10.0, 10.0, &[-0.04, 0.0, 0.04]),
            ParameterInfo::number("y_m", "m", -10.0, 10.0, &[-0.04, 0.0, 0.04]),
        ],
        repeats: true,
        kinematic: false,
        acts: When::Always,
        condition: "always",
        follows: &[
            (Channel::Longitudinal, Variable::Command),
            (Channel::Yaw, Variable::Command),
        ],
        experiment: Experiment::AddedMass,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            mass_kg: values.number("mass_kg"),
            x_m: values.number("x_m"),
            y_m: values.number("y_m"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        let (m, x, y) = (self.mass_kg, self.x_m, self.y_m);
        parts.payload_mass += m;
        parts.payload_moment[0] += m * x;
        parts.payload_moment[1] += m * y;
        parts.payload_inertia += m * (x * x + y * y);
    }
}
