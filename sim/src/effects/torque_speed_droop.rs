//! The motor weakens with speed.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct TorqueSpeedDroop<S> {
    coefficient: S,
}

impl<S: Scalar> Effect<S> for TorqueSpeedDroop<S> {
    const INFO: Info = Info {
        id: "torque_speed_droop",
        summary: "drive torque falls with wheel speed (back-EMF, viscous bearing)",
        equation: "tau = tau_c - k omega",
        source: "DC motor's torque-speed line",
        place: Place::DriveTrain,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            "coefficient",
            "N m s/rad",
            0.0,
            10.0,
            &[5e-4, 2e-3, 8e-3],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "the more, the faster the wheels turn",
        follows: &[
            (Channel::WheelRight, Variable::Speed),
            (Channel::WheelLeft, Variable::Speed),
        ],
        experiment: Experiment::LiftedWheels,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            coefficient: values.number("coefficient"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.drive.droop += self.coefficient;
    }
}
