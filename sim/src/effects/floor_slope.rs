//! Floor slope: gravity has a component along the floor.

use super::parameter::{direction, size};
use super::{Channel, Effect, Info, Manoeuvre, Variable, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(FloorSlope {
    grade,
    downhill_rad
});

impl<S: Scalar> Effect<S> for FloorSlope<S> {
    const INFO: Info = Info::body(
        "floor_slope",
        "the floor tilts; direction in the world frame",
        Manoeuvre::Ramp,
    )
    .equation("F = m g sin(atan(grade)) downhill, at the centre of all mass")
    .source("component of weight")
    .parameters(&[
        size("grade", "1", [0.0, 1.0], &[0.002, 0.008, 0.03]),
        direction("downhill_rad", 7.0, &[0.0, 1.6, 3.1, -1.6]),
    ])
    .follows(&[(Channel::Longitudinal, Variable::Heading)]);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        let (sin, cos) = self.downhill_rad.sin_cos();
        parameters.gradient[0] += self.grade * cos;
        parameters.gradient[1] += self.grade * sin;
    }
}
