//! Motion law: a speed or turn rate as a table over one driver, added to what the wheels carry the body
//! with.
//!
//! For robots whose commands prescribe the wheels' speeds. The added turn is about the middle of the axle,
//! so that it adds nothing across the axle. Drivers: `t` (s), `v` and `w` (speed in m/s and turn rate in
//! rad/s with which the wheels alone carry the body), `heading` (rad, from -pi to pi), `x` and `y` of c
//! (m).

use super::info::TWIST;
use super::law::{DRIVERS, Law};
use super::parameter::{Role, list, text};
use super::{Channel, Effect, FromValues, Info, Manoeuvre, Motion, Values};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::{Pair, Scalar};

/// The effect described by its [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct MotionLaw<S>(Law<S>);

impl<S: Scalar> FromValues<S> for MotionLaw<S> {
    fn from_values(values: &Values<S>) -> Self {
        Self(Law::new(values))
    }
}

impl<S: Scalar> Effect<S> for MotionLaw<S> {
    const INFO: Info = Info::contact(
        "motion_law",
        "a speed or turn rate as a table over one driver, added to what the wheels carry the \
            body with (kinematic model)",
    )
    .equation(
        "v = v_wheels + f(z), or w = w_wheels + f(z), f linear between the knots and constant \
            beyond them",
    )
    .source("piecewise linear map")
    .channels(&[Channel::Longitudinal, Channel::Lateral, Channel::Yaw])
    .parameters(&[
        text("acts_on", &["speed", "turn_rate"]),
        text("driver", DRIVERS),
        list(Role::Knots, "knots", "unit of the driver", 1e6),
        list(Role::Entries, "values", "m/s or rad/s", 1e3),
    ])
    .repeats()
    .kinematic()
    .condition("where its table is not 0")
    .follows(TWIST)
    .manoeuvre(Manoeuvre::Steps);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.of_speeds = Some("effects.motion_law");
    }

    fn carry(&self, motion: &Motion<S>, [speed, turn_rate]: &mut Pair<S>) {
        let added = self.0.at(motion);
        match self.0.acts_on {
            "turn_rate" => *turn_rate += added,
            _ => *speed += added,
        }
    }

    fn has_carry(&self) -> bool {
        true
    }
}
