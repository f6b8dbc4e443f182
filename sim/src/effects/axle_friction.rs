//! Dry friction in the wheels' bearings.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct AxleFriction<S> {
    torque_nm: S,
}

impl<S: Scalar> Effect<S> for AxleFriction<S> {
    const INFO: Info = Info {
        id: "axle_friction",
        summary: "Coulomb torque against wheel rotation, both wheels alike",
        equation: "tau = -tau_0 sign(omega)",
        source: "Coulomb's law",
        place: Place::DriveTrain,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            "torque_nm",
            "N m",
            0.0,
            100.0,
            &[0.002, 0.006, 0.02],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "whenever it moves",
        follows: &[
            (Channel::WheelRight, Variable::Speed),
            (Channel::WheelLeft, Variable::Speed),
        ],
        experiment: Experiment::LiftedWheels,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            torque_nm: values.number("torque_nm"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.axle_torque = Some(self.torque_nm);
    }
}
