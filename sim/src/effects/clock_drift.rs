//! Clock drift: the clock of one stream runs fast or slow.

use super::parameter::{size, text};
use super::{Channel, Effect, FromValues, Info, Values};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

/// Streams with a clock of their own.
const STREAMS: &[&str] = &["pose", "wheels", "imu"];

/// The effect described by its [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct ClockDrift<S> {
    rate: S,
    stream: &'static str,
}

impl<S: Scalar> FromValues<S> for ClockDrift<S> {
    fn from_values(values: &Values<S>) -> Self {
        Self {
            rate: values.number("rate"),
            stream: values.text("stream"),
        }
    }
}

impl<S: Scalar> Effect<S> for ClockDrift<S> {
    const INFO: Info = Info::sensor(
        "clock_drift",
        "stamp = t (1 + rate) in one stream",
        &[
            Channel::SensorPose,
            Channel::SensorWheels,
            Channel::SensorImu,
        ],
    )
    .equation("z(t (1 + k)) = y(t)")
    .source("first order of a clock's error")
    .parameters(&[
        size("rate", "s/s", [-0.1, 0.1], &[-0.002, -2e-4, 2e-4, 0.002]),
        text("stream", STREAMS),
    ])
    .repeats();

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        let rates = &mut parameters.sensing.clock_rate;
        match self.stream {
            "wheels" => rates.wheels = self.rate,
            "imu" => rates.imu = self.rate,
            _ => rates.pose = self.rate,
        }
    }
}
