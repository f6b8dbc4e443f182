//! The camera is stamped late.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct PoseLatency<S> {
    latency_s: S,
}

impl<S: Scalar> Effect<S> for PoseLatency<S> {
    const INFO: Info = Info {
        id: "pose_latency",
        summary: "stamp = true time + latency in the pose stream",
        equation: "z(t) = y(t - T)",
        source: "pure delay",
        place: Place::Sensor,
        channels: &[Channel::SensorPose],
        parameters: &[ParameterInfo::number(
            "latency_s",
            "s",
            -2.0,
            2.0,
            &[-0.1, -0.02, 0.01, 0.04, 0.15, 0.4],
        )],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "always",
        follows: &[],
        experiment: Experiment::SharpStarts,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            latency_s: values.number("latency_s"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.sensing.latency_s.pose = self.latency_s;
    }
}
