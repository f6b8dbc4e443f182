//! Accelerating presses the driven wheels down.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct LoadTransfer<S> {
    com_height_m: S,
}

impl<S: Scalar> Effect<S> for LoadTransfer<S> {
    const INFO: Info = Info {
        id: "load_transfer",
        summary: "longitudinal acceleration shifts load between caster and wheels (Eq. 6 leaves it \
            out)",
        equation: "N_ca (d + e) = m_t g d - m_t a h",
        source: "moment balance about the axle's contact line",
        place: Place::Contact,
        channels: &[
            Channel::Longitudinal,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            "com_height_m",
            "m",
            0.0,
            1.0,
            &[0.01, 0.03, 0.08],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "always",
        follows: &[(Channel::Longitudinal, Variable::Command)],
        experiment: Experiment::AddedMass,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            com_height_m: values.number("com_height_m"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.transfer_height = Some(self.com_height_m);
    }
}
