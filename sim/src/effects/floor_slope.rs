//! Floor slope: gravity has a component along the floor.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(FloorSlope {
    grade,
    downhill_rad
});

impl<S: Scalar> Effect<S> for FloorSlope<S> {
    const INFO: Info = Info {
        id: "floor_slope",
        summary: "the floor tilts; direction in the world frame",
        equation: "F = m g sin(atan(grade)) downhill, at the centre of all mass",
        source: "component of weight",
        site: ModelSite::Body,
        channels: &[Channel::Longitudinal, Channel::Lateral, Channel::Yaw],
        parameters: &[
            ParameterInfo::number(Role::Size, "grade", "1", 0.0, 1.0, &[0.002, 0.008, 0.03]),
            ParameterInfo::number(
                Role::Direction,
                "downhill_rad",
                "rad",
                -7.0,
                7.0,
                &[0.0, 1.6, 3.1, -1.6],
            ),
        ],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "always",
        follows: &[(Channel::Longitudinal, Variable::Heading)],
        manoeuvre: Manoeuvre::Ramp,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        let (sin, cos) = self.downhill_rad.sin_cos();
        parameters.gradient[0] += self.grade * cos;
        parameters.gradient[1] += self.grade * sin;
    }
}
