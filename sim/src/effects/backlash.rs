//! Play in the gears.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct Backlash<S> {
    gap_rad: S,
}

impl<S: Scalar> Effect<S> for Backlash<S> {
    const INFO: Info = Info {
        id: "backlash",
        summary: "play between motor and wheel, starting in its middle, contact without \
            rebound; a quarter of I_wy turns with the motor, where the encoder is",
        equation: "tau_wheel = 0 while |theta_m - theta_w| < gap / 2",
        source: "dead zone with inelastic contact",
        place: Place::DriveTrain,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
            Channel::SensorWheels,
        ],
        parameters: &[ParameterInfo::number(
            "gap_rad",
            "rad",
            1e-4,
            1.0,
            &[0.01, 0.03, 0.08],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Apart,
        condition: "whenever the drive torque changes sign",
        follows: &[
            (Channel::WheelRight, Variable::Command),
            (Channel::WheelLeft, Variable::Command),
        ],
        experiment: Experiment::Steps,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            gap_rad: values.number("gap_rad"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.drive.gap_rad = Some(self.gap_rad);
    }
}
