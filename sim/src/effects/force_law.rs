//! Force law: a force or moment on the body as a table over one driver.
//!
//! Drivers: `t` (s), `v` and `w` (speed of c along the body in m/s, and yaw rate in rad/s), `heading` (rad,
//! from -pi to pi), `x` and `y` of c (m).

use super::info::{ALL_MOTION, TWIST};
use super::law::{DRIVERS, Law};
use super::parameter::{Role, list, text};
use super::{Effect, FromValues, Info, Manoeuvre, Motion, Values, Wrench};
use crate::parts::scalar::Scalar;

/// The effect described by its [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct ForceLaw<S>(Law<S>);

impl<S: Scalar> FromValues<S> for ForceLaw<S> {
    fn from_values(values: &Values<S>) -> Self {
        Self(Law::new(values))
    }
}

impl<S: Scalar> Effect<S> for ForceLaw<S> {
    const INFO: Info = Info::body(
        "force_law",
        "a force or moment on the body as a table over one driver (dynamic model)",
        Manoeuvre::CoastDown,
    )
    .equation("F = f(z), or M = f(z), f linear between the knots and constant beyond them")
    .source("piecewise linear map")
    .channels(ALL_MOTION)
    .parameters(&[
        text("acts_on", &["surge_force", "yaw_moment"]),
        text("driver", DRIVERS),
        list(Role::Knots, "knots", "unit of the driver", 1e6),
        list(Role::Entries, "values", "N or N m", 1e5),
    ])
    .repeats()
    .condition("where its table is not 0")
    .follows(TWIST);

    fn force(&self, motion: &Motion<S>, wrench: &mut Wrench<S>) {
        let force = self.0.at(motion);
        match self.0.acts_on {
            "yaw_moment" => wrench.moment += force,
            _ => wrench.along += force,
        }
    }

    fn has_force(&self) -> bool {
        true
    }
}
