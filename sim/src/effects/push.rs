//! Push: a short external force on the body.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, Motion, ParameterInfo, Role, When, Wrench, numbers,
};
use crate::parts::scalar::{Scalar, larger};

/// Duration of a push (s).
const DURATION_S: f64 = 0.06;

numbers!(Push {
    t_s,
    impulse_n_s,
    direction_rad
});

impl<S: Scalar> Effect<S> for Push<S> {
    const INFO: Info = Info {
        id: "push",
        summary: "an external force on c lasting 60 ms from t_s, world frame",
        equation: "F = J / 60 ms for t_s < t < t_s + 60 ms",
        source: "impulse and momentum",
        site: ModelSite::Body,
        channels: &[Channel::Longitudinal, Channel::Lateral, Channel::Yaw],
        parameters: &[
            ParameterInfo::number(Role::Time, "t_s", "s", 0.0, 1e6, &[]),
            ParameterInfo::number(
                Role::Size,
                "impulse_n_s",
                "N s",
                0.0,
                1e3,
                &[0.02, 0.1, 0.4],
            ),
            ParameterInfo::number(
                Role::Direction,
                "direction_rad",
                "rad",
                -7.0,
                7.0,
                &[0.0, 1.6, 3.1, -1.6],
            ),
        ],
        repeats: true,
        kinematic: false,
        acts: When::Once,
        condition: "once",
        follows: &[],
        manoeuvre: Manoeuvre::NobodyNear,
    };

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
