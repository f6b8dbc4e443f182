//! Pose offset: the camera or motion capture tracks another point or heading than declared.

use super::{Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, When, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(PoseOffset { x_m, y_m, yaw_rad });

impl<S: Scalar> Effect<S> for PoseOffset<S> {
    const INFO: Info = Info {
        id: "pose_offset",
        summary: "really tracked point minus declared point, body frame; measured minus true yaw",
        equation: "p = c + R(phi) o; yaw = phi + o_yaw",
        source: "rigid-body geometry",
        site: ModelSite::Sensor,
        channels: &[Channel::SensorPose],
        parameters: &[
            ParameterInfo::number(Role::Position, "x_m", "m", -10.0, 10.0, &[-0.05, 0.05]),
            ParameterInfo::number(Role::Position, "y_m", "m", -10.0, 10.0, &[-0.05, 0.05]),
            ParameterInfo::number(Role::Direction, "yaw_rad", "rad", -3.2, 3.2, &[-0.05, 0.05]),
        ],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "always",
        follows: &[],
        manoeuvre: Manoeuvre::SpinInPlace,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.sensing.pose_offset = [self.x_m, self.y_m, self.yaw_rad];
    }
}
