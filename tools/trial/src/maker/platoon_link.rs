//! Position messages between the robots of a platoon.

use std::sync::Arc;

use slipstream_bus::Parameter;
use slipstream_recording::recording::LinkMessage;

use super::manoeuvre::rounded;
use super::random::RandomStream;
use super::robot::Robot;
use super::scene::Scene;
use super::sensors::{POSE_M, POSE_RAD, wrapped};

/// Probability that a message is lost.
const LOSS: f64 = 0.02;
/// Shortest and longest delay of a message (s).
const DELAY_S: [f64; 2] = [0.02, 0.045];

/// The latest message that robot `i` has received by `t_s` (s).
pub(crate) fn latest(messages: &[LinkMessage], i: usize, t_s: f64) -> Option<&LinkMessage> {
    let name = Scene::name(i);
    let arrived = |message: &&LinkMessage| message.t_received_s.is_some_and(|at| at <= t_s);
    messages
        .iter()
        .rev()
        .filter(|message| *message.to == *name)
        .find(arrived)
}

/// Sends the position of each robot to its follower at `t_s` (s); a concealed link delay makes it older.
pub(crate) fn send(
    scene: &Scene,
    robots: &[Robot],
    t_s: f64,
    random: &mut RandomStream,
    messages: &mut Vec<LinkMessage>,
) {
    for i in 1..robots.len() {
        let delays = scene.robots[i]
            .concealed
            .iter()
            .filter(|effect| effect.effect == "link_delay");
        let age_s: f64 = delays
            .flat_map(|effect| &effect.parameters)
            .map(number)
            .sum();
        let [x, y, yaw] = robots[i - 1].pose_at(t_s - age_s);
        let lost = random.bernoulli(LOSS);
        let delay_s = random.uniform(DELAY_S[0], DELAY_S[1]);
        messages.push(LinkMessage {
            t_sent_s: rounded(t_s),
            t_received_s: (!lost).then(|| rounded(t_s + delay_s)),
            from: Arc::from(Scene::name(i - 1)),
            to: Arc::from(Scene::name(i)),
            x_m: rounded(x + random.normal(POSE_M)),
            y_m: rounded(y + random.normal(POSE_M)),
            yaw_rad: rounded(wrapped(yaw + random.normal(POSE_RAD))),
            v_m_s: f64::NAN,
            w_rad_s: f64::NAN,
        });
    }
}

fn number((_, value): &(String, Parameter)) -> f64 {
    match value {
        Parameter::Number(number) => *number,
        Parameter::Text(_) | Parameter::List(_) => 0.0,
    }
}
