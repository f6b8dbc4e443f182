//! Traction at the driven wheels ends at Coulomb friction.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::{Grip, Parts};
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct WheelSlip<S> {
    friction_static: S,
    friction_kinetic: S,
}

impl<S: Scalar> Effect<S> for WheelSlip<S> {
    const INFO: Info = Info {
        id: "wheel_slip",
        summary: "traction at each driven wheel limited by Coulomb friction, both directions \
            together",
        equation: "|F| <= mu_s N while rolling; F = -mu_k N s / |s| at slip velocity s",
        source: "Konduri, Torres and Pagilla, Eq. 9 and 10",
        place: Place::Contact,
        channels: &[
            Channel::Longitudinal,
            Channel::Lateral,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[
            ParameterInfo::number("friction_static", "1", 1e-3, 10.0, &[0.2]),
            ParameterInfo::number("friction_kinetic", "1", 1e-3, 10.0, &[0.2]),
        ],
        repeats: false,
        kinematic: false,
        acts: When::Sliding,
        condition: "whenever traction exceeds friction",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        experiment: Experiment::UntilItSlips,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            friction_static: values.number("friction_static"),
            friction_kinetic: values.number("friction_kinetic"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.grip = Some(Grip {
            friction_static: self.friction_static,
            friction_kinetic: self.friction_kinetic,
        });
    }
}
