//! A slippery, or sticky, spot.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, When};
use crate::parts::Grip;
use crate::scalar::{Pair, Scalar, length};

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct FrictionPatch<S> {
    x_m: S,
    y_m: S,
    radius_m: S,
    friction: S,
}

impl<S: Scalar> Effect<S> for FrictionPatch<S> {
    const INFO: Info = Info {
        id: "friction_patch",
        summary: "a disc of floor whose friction replaces both coefficients where a wheel's contact \
            lies in it",
        equation: "mu_s = mu_k = mu where |p - p0| < R",
        source: "Coulomb's law",
        place: Place::Contact,
        channels: &[
            Channel::Longitudinal,
            Channel::Lateral,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[
            ParameterInfo::number("x_m", "m", -1e3, 1e3, &[]),
            ParameterInfo::number("y_m", "m", -1e3, 1e3, &[]),
            ParameterInfo::number("radius_m", "m", 1e-3, 1e3, &[0.05, 0.1, 0.2, 0.4]),
            ParameterInfo::number("friction", "1", 1e-3, 10.0, &[0.06, 0.1, 0.15, 0.2, 0.3]),
        ],
        repeats: true,
        kinematic: false,
        acts: When::Inside,
        condition: "while a wheel is on it",
        follows: &[],
        experiment: Experiment::UntilItSlips,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            x_m: values.number("x_m"),
            y_m: values.number("y_m"),
            radius_m: values.number("radius_m"),
            friction: values.number("friction"),
        }
    }

    fn floor(&self, contact: Pair<S>) -> Option<(S, Grip<S>)> {
        let offset = [contact[0] - self.x_m, contact[1] - self.y_m];
        let grip = Grip {
            friction_static: self.friction,
            friction_kinetic: self.friction,
        };
        Some((self.radius_m - length(offset), grip))
    }
}
