//! Friction patch: a disc of floor with a friction of its own.

use super::parameter::{Role, limit, number, position};
use super::{Effect, Info, When, numbers};
use crate::parts::parameters::Friction;
use crate::parts::scalar::{Pair, Scalar, length};

numbers!(FrictionPatch {
    x_m,
    y_m,
    radius_m,
    friction
});

impl<S: Scalar> Effect<S> for FrictionPatch<S> {
    const INFO: Info = Info::contact(
        "friction_patch",
        "a disc of floor whose friction replaces both coefficients where a wheel's contact \
            lies in it",
    )
    .equation("mu_s = mu_k = mu where |p - p0| < R")
    .source("Coulomb's law")
    .parameters(&[
        position("x_m", 1e3, &[]),
        position("y_m", 1e3, &[]),
        number(
            Role::Radius,
            "radius_m",
            "m",
            [1e-3, 1e3],
            &[0.05, 0.1, 0.2, 0.4],
        ),
        limit("friction", "1", [1e-3, 10.0], &[0.06, 0.1, 0.15, 0.2, 0.3]),
    ])
    .repeats()
    .acts(When::Inside)
    .condition("while a wheel is on it");

    fn floor(&self, contact: Pair<S>) -> Option<(S, Friction<S>)> {
        let offset = [contact[0] - self.x_m, contact[1] - self.y_m];
        let friction = Friction {
            friction_static: self.friction,
            friction_kinetic: self.friction,
        };
        Some((self.radius_m - length(offset), friction))
    }
}
