//! Latency: time stamps of one stream are late.

use super::parameter::size;
use super::{Channel, Effect, Info, ParameterInfo, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(PoseLatency { latency_s });
numbers!(WheelsLatency { latency_s });
numbers!(ImuLatency { latency_s });

/// What is added to time stamps.
const LATENCY: ParameterInfo = size(
    "latency_s",
    "s",
    [-2.0, 2.0],
    &[-0.1, -0.02, 0.01, 0.04, 0.15, 0.4],
);

const fn latency(id: &'static str, summary: &'static str, channels: &'static [Channel]) -> Info {
    Info::sensor(id, summary, channels)
        .equation("z(t) = y(t - T)")
        .source("pure delay")
        .parameters(&[LATENCY])
}

impl<S: Scalar> Effect<S> for PoseLatency<S> {
    const INFO: Info = latency(
        "pose_latency",
        "stamp = true time + latency in the pose stream",
        &[Channel::SensorPose],
    );

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.sensing.latency_s.pose = self.latency_s;
    }
}

impl<S: Scalar> Effect<S> for WheelsLatency<S> {
    const INFO: Info = latency(
        "wheels_latency",
        "stamp = true time + latency in the wheels stream",
        &[Channel::SensorWheels],
    );

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.sensing.latency_s.wheels = self.latency_s;
    }
}

impl<S: Scalar> Effect<S> for ImuLatency<S> {
    const INFO: Info = latency(
        "imu_latency",
        "stamp = true time + latency in the imu stream",
        &[Channel::SensorImu],
    );

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.sensing.latency_s.imu = self.latency_s;
    }
}
