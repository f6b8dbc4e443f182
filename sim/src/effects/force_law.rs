//! Force law: a force or moment on the body as a table over one driver.
//!
//! Drivers: `t` (s), `v` and `w` (speed of c along the body in m/s, and yaw rate in rad/s), `heading` (rad,
//! from -pi to pi), `x` and `y` of c (m).

use super::law::{DRIVERS, Law};
use super::{
    Channel, Effect, FromValues, Info, Manoeuvre, ModelSite, Motion, ParameterInfo, Role, Values,
    Variable, When, Wrench,
};
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
    const INFO: Info = Info {
        id: "force_law",
        summary: "a force or moment on the body as a table over one driver (dynamic model)",
        equation: "F = f(z), or M = f(z), f linear between the knots and constant beyond them",
        source: "piecewise linear map",
        site: ModelSite::Body,
        channels: &[
            Channel::Longitudinal,
            Channel::Lateral,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[
            ParameterInfo::text("acts_on", &["surge_force", "yaw_moment"]),
            ParameterInfo::text("driver", DRIVERS),
            ParameterInfo::list(Role::Knots, "knots", "unit of the driver", [-1e6, 1e6]),
            ParameterInfo::list(Role::Entries, "values", "N or N m", [-1e5, 1e5]),
        ],
        repeats: true,
        kinematic: false,
        acts: When::Always,
        condition: "where its table is not 0",
        follows: &[
            (Channel::Longitudinal, Variable::Speed),
            (Channel::Yaw, Variable::TurnRate),
        ],
        manoeuvre: Manoeuvre::CoastDown,
    };

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
