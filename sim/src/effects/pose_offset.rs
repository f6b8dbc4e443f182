//! The camera tracks another point.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct PoseOffset<S> {
    x_m: S,
    y_m: S,
    yaw_rad: S,
}

impl<S: Scalar> Effect<S> for PoseOffset<S> {
    const INFO: Info = Info {
        id: "pose_offset",
        summary: "really tracked point minus declared point, body frame; measured minus true yaw",
        equation: "p = c + R(phi) o; yaw = phi + o_yaw",
        source: "rigid-body geometry",
        place: Place::Sensor,
        channels: &[Channel::SensorPose],
        parameters: &[
            ParameterInfo::number("x_m", "m", -10.0, 10.0, &[-0.05, 0.05]),
            ParameterInfo::number("y_m", "m", -10.0, 10.0, &[-0.05, 0.05]),
            ParameterInfo::number("yaw_rad", "rad", -3.2, 3.2, &[-0.05, 0.05]),
        ],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "always",
        follows: &[],
        experiment: Experiment::SpinInPlace,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            x_m: values.number("x_m"),
            y_m: values.number("y_m"),
            yaw_rad: values.number("yaw_rad"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.sensing.pose_offset = [self.x_m, self.y_m, self.yaw_rad];
    }
}
