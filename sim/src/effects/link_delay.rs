//! Messages tell the past.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct LinkDelay<S> {
    delay_s: S,
}

impl<S: Scalar> Effect<S> for LinkDelay<S> {
    const INFO: Info = Info {
        id: "link_delay",
        summary: "a message's content is older than its stamp says; the robot is the receiver",
        equation: "q(t) = q_sender(t - T)",
        source: "pure delay",
        place: Place::Link,
        channels: &[Channel::Link],
        parameters: &[ParameterInfo::number(
            "delay_s",
            "s",
            0.0,
            10.0,
            &[0.01, 0.04, 0.15],
        )],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "always",
        follows: &[],
        experiment: Experiment::Follow,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            delay_s: values.number("delay_s"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.sensing.link_delay_s = self.delay_s;
    }
}
