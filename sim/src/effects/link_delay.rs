//! Link delay: the content of messages is older than their stamps say.

use super::{Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, When, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(LinkDelay { delay_s });

impl<S: Scalar> Effect<S> for LinkDelay<S> {
    const INFO: Info = Info {
        id: "link_delay",
        summary: "a message's content is older than its stamp says; the robot is the receiver",
        equation: "q(t) = q_sender(t - T)",
        source: "pure delay",
        site: ModelSite::Link,
        channels: &[Channel::Link],
        parameters: &[ParameterInfo::number(
            Role::Size,
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
        manoeuvre: Manoeuvre::Follow,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.sensing.link_delay_s = self.delay_s;
    }
}
