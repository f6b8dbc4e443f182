//! Pose offset: the camera or motion capture tracks another point or heading than declared.

use super::parameter::{direction, position};
use super::{Channel, Effect, Info, Manoeuvre, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(PoseOffset { x_m, y_m, yaw_rad });

impl<S: Scalar> Effect<S> for PoseOffset<S> {
    const INFO: Info = Info::sensor(
        "pose_offset",
        "really tracked point minus declared point, body frame; measured minus true yaw",
        &[Channel::SensorPose],
    )
    .equation("p = c + R(phi) o; yaw = phi + o_yaw")
    .source("rigid-body geometry")
    .parameters(&[
        position("x_m", 10.0, &[-0.05, 0.05]),
        position("y_m", 10.0, &[-0.05, 0.05]),
        direction("yaw_rad", 3.2, &[-0.05, 0.05]),
    ])
    .manoeuvre(Manoeuvre::SpinInPlace);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.sensing.pose_offset = [self.x_m, self.y_m, self.yaw_rad];
    }
}
