//! Link delay: the content of messages is older than their stamps say.

use super::parameter::size;
use super::{Channel, Effect, Info, Manoeuvre, ModelSite, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(LinkDelay { delay_s });

impl<S: Scalar> Effect<S> for LinkDelay<S> {
    const INFO: Info = Info::new(
        "link_delay",
        "a message's content is older than its stamp says; the robot is the receiver",
        ModelSite::Link,
        Manoeuvre::Follow,
    )
    .equation("q(t) = q_sender(t - T)")
    .source("pure delay")
    .channels(&[Channel::Link])
    .parameters(&[size("delay_s", "s", [0.0, 10.0], &[0.01, 0.04, 0.15])])
    .kinematic();

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.sensing.link_delay_s = self.delay_s;
    }
}
