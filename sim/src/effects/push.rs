//! Push: a short external force on the body.

use super::parameter::{Role, direction, number, size};
use super::{Effect, Info, Manoeuvre, Motion, When, Wrench, numbers};
use crate::parts::scalar::{Scalar, larger};

/// Duration of a push (s).
const DURATION_S: f64 = 0.06;

numbers!(Push {
    t_s,
    impulse_n_s,
    direction_rad
});

impl<S: Scalar> Effect<S> for Push<S> {
    const INFO: Info = Info::body(
        "push",
        "an external force on c lasting 60 ms from t_s, world frame",
        Manoeuvre::NobodyNear,
    )
    .equation("F = J / 60 ms for t_s < t < t_s + 60 ms")
    .source("impulse and momentum")
    .parameters(&[
        number(Role::Time, "t_s", "s", [0.0, 1e6], &[]),
        size("impulse_n_s", "N s", [0.0, 1e3], &[0.02, 0.1, 0.4]),
        direction("direction_rad", 7.0, &[0.0, 1.6, 3.1, -1.6]),
    ])
    .repeats()
    .acts(When::Once)
    .condition("once");

    fn force(&self, motion: &Motion<S>, wrench: &mut Wrench<S>) {
        let from = larger(self.t_s, S::constant(motion.t_s));
        let end = self.t_s + DURATION_S;
        let to_end = end - (motion.t_s + motion.over_s);
        let to = if to_end.value() < 0.0 {
            end
        } else {
            end - to_end
        };
        let overlap = to - from;
        if overlap.value() <= 0.0 {
            return;
        }
        let force = self.impulse_n_s * overlap / (DURATION_S * motion.over_s);
        let (sin, cos) = self.direction_rad.sin_cos();
        let [heading_cos, heading_sin] = motion.heading;
        wrench.along += force * (cos * heading_cos + sin * heading_sin);
        wrench.across += force * (sin * heading_cos - cos * heading_sin);
    }

    fn has_force(&self) -> bool {
        true
    }
}
