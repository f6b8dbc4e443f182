//! The battery runs down.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct SupplySag<S> {
    rate_per_s: S,
}

impl<S: Scalar> Effect<S> for SupplySag<S> {
    const INFO: Info = Info {
        id: "supply_sag",
        summary: "drive strength falls in proportion to time from the recording's start",
        equation: "y = u (1 - k t)",
        source: "first order in time of a falling supply",
        place: Place::Command,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            "rate_per_s",
            "1/s",
            -0.1,
            0.1,
            &[-0.002, 0.002, 0.008],
        )],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "always",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        experiment: Experiment::SameAgain,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            rate_per_s: values.number("rate_per_s"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.drive.direct = false;
        parts.drive.sag_per_s = self.rate_per_s;
    }
}
