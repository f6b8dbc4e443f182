//! The floor tilts.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct FloorSlope<S> {
    grade: S,
    downhill_rad: S,
}

impl<S: Scalar> Effect<S> for FloorSlope<S> {
    const INFO: Info = Info {
        id: "floor_slope",
        summary: "the floor tilts; direction in the world frame",
        equation: "F = m g sin(atan(grade)) downhill, at the centre of all mass",
        source: "component of weight",
        place: Place::Body,
        channels: &[Channel::Longitudinal, Channel::Lateral, Channel::Yaw],
        parameters: &[
            ParameterInfo::number("grade", "1", 0.0, 1.0, &[0.002, 0.008, 0.03]),
            ParameterInfo::number("downhill_rad", "rad", -7.0, 7.0, &[0.0, 1.6, 3.1, -1.6]),
        ],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "always",
        follows: &[(Channel::Longitudinal, Variable::Heading)],
        experiment: Experiment::Ramp,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            grade: values.number("grade"),
            downhill_rad: values.number("downhill_rad"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        let (sin, cos) = self.downhill_rad.sin_cos();
        parts.gradient[0] += self.grade * cos;
        parts.gradient[1] += self.grade * sin;
    }
}
