//! A moment of constant size against turning.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct YawScrub<S> {
    moment_nm: S,
}

impl<S: Scalar> Effect<S> for YawScrub<S> {
    const INFO: Info = Info {
        id: "yaw_scrub",
        summary: "moment of constant size against turning",
        equation: "M = -M_0 sign(dphi/dt)",
        source: "Coulomb's law",
        place: Place::Contact,
        channels: &[Channel::Yaw],
        parameters: &[ParameterInfo::number(
            "moment_nm",
            "N m",
            0.0,
            100.0,
            &[0.003, 0.01, 0.04],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "whenever it turns",
        follows: &[(Channel::Yaw, Variable::TurnRate)],
        experiment: Experiment::SpinInPlace,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            moment_nm: values.number("moment_nm"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.yaw_moment = Some(self.moment_nm);
    }
}
