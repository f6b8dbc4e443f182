//! IMU latency: time stamps of the inertial sensor are late.

use super::{Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, When, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(ImuLatency { latency_s });

impl<S: Scalar> Effect<S> for ImuLatency<S> {
    const INFO: Info = Info {
        id: "imu_latency",
        summary: "stamp = true time + latency in the imu stream",
        equation: "z(t) = y(t - T)",
        source: "pure delay",
        site: ModelSite::Sensor,
        channels: &[Channel::SensorImu],
        parameters: &[ParameterInfo::number(
            Role::Size,
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
        manoeuvre: Manoeuvre::SharpStarts,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.sensing.latency_s.imu = self.latency_s;
    }
}
