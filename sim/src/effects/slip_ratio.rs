//! Slip ratio: the wheels' contacts move by less than the wheels turn.
//!
//! In a dynamic model the contact rolls at (1 - s) r times the wheel's speed, and the zero of its slip
//! velocity lies there, while its force F acts on the wheel with the torque r F as before. The floor takes
//! the power s r ω F: it takes some while the wheel drives, and gives some while it brakes, if s > 0.

use super::info::TWIST;
use super::parameter::size;
use super::{Channel, Effect, FromValues, Info, Manoeuvre, Values};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

/// The effect described by its [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct SlipRatio<S> {
    ratio: S,
    asymmetry: S,
}

impl<S: Scalar> FromValues<S> for SlipRatio<S> {
    fn from_values(values: &Values<S>) -> Self {
        Self {
            ratio: values.number("ratio"),
            asymmetry: values.get("asymmetry").unwrap_or(S::constant(0.0)),
        }
    }
}

impl<S: Scalar> Effect<S> for SlipRatio<S> {
    const INFO: Info = Info::contact(
        "slip_ratio",
        "each wheel's contact moves by (1 - ratio) of what the wheel turns (soft floor, carpet)",
    )
    .equation("v_i = (1 - s_i) r omega_i, s_r = s + a / 2, s_l = s - a / 2")
    .source("definition of the slip ratio of a driven wheel")
    .channels(&[Channel::Longitudinal, Channel::Yaw])
    .parameters(&[
        size("ratio", "1", [-0.5, 0.95], &[0.02, 0.1, 0.3]),
        size("asymmetry", "1", [-0.5, 0.5], &[-0.02, 0.02]).as_optional(),
    ])
    .kinematic()
    .follows(TWIST)
    .manoeuvre(Manoeuvre::HandTurned);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        let half = self.asymmetry * 0.5;
        let slips = [self.ratio + half, self.ratio - half];
        parameters.travel = Some(slips.map(|slip| S::constant(1.0) - slip));
    }
}
