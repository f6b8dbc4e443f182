//! Guess of a topic map from the types and names of the topics.

use super::survey::{Topic, wheel_joints};
use super::topic_map::{Quantity, Source, TopicMap};
use crate::decode::MessageSelector;
use crate::recording::is_robot_name;
use crate::table::StreamKind;

/// First parts of a topic that name a sensor or driver, not a robot.
const NOT_ROBOTS: [&str; 12] = [
    "imu",
    "odom",
    "odometry",
    "camera",
    "vicon",
    "mocap",
    "optitrack",
    "cmd_vel",
    "sensors",
    "joint_states",
    "diff_drive_controller",
    "platform",
];

/// The most likely stream of each topic. Of several topics for one stream, the one with most
/// messages.
pub(super) fn guess(topics: &[Topic]) -> TopicMap {
    let mut candidates: Vec<(u64, Source)> = Vec::new();
    for topic in topics
        .iter()
        .filter(|topic| topic.channel.encoding == "cdr")
    {
        if let Some(source) = guess_one(topic) {
            let is_same = |(_, other): &&mut (u64, Source)| {
                (&other.robot, other.kind) == (&source.robot, source.kind)
            };
            match candidates.iter_mut().find(is_same) {
                Some(other) if other.0 < topic.messages => *other = (topic.messages, source),
                Some(_) => {}
                None => candidates.push((topic.messages, source)),
            }
        }
    }
    candidates.sort_by(|(_, a), (_, b)| (&a.robot, a.kind).cmp(&(&b.robot, b.kind)));
    TopicMap {
        log_times: false,
        sources: candidates.into_iter().map(|(_, source)| source).collect(),
    }
}

/// The most likely stream of a topic, if any.
fn guess_one(topic: &Topic) -> Option<Source> {
    let name = topic.channel.topic.to_lowercase();
    let contains = |words: &[&str]| words.iter().any(|word| name.contains(word));
    let is_command = contains(&["cmd", "command", "target", "desired", "setpoint"]);
    let is_truth = contains(&[
        "truth",
        "mocap",
        "vicon",
        "optitrack",
        "gt",
        "pose",
        "camera",
    ]);
    let mut selector = MessageSelector::default();
    let mut quantity = None;
    let kind = match (topic.channel.schema.rsplit('/').next()?, &topic.joints) {
        ("Twist" | "TwistStamped", _) if is_command => StreamKind::Command,
        ("TwistStamped", _) => StreamKind::Odometry,
        ("Odometry", _) if is_truth => StreamKind::Pose,
        ("Odometry", _) => StreamKind::Odometry,
        ("PoseStamped" | "PoseWithCovarianceStamped", _) => StreamKind::Pose,
        ("Imu", _) => StreamKind::Imu,
        ("EncoderTicks", _) => StreamKind::Wheels,
        ("JointState", Some(joints)) => {
            selector = wheel_joints(&joints.names)?;
            let (kind, list) = match is_command {
                true if joints.has_torques => (StreamKind::Command, Quantity::Torque),
                true if joints.has_speeds => (StreamKind::Command, Quantity::Speed),
                false if joints.has_angles => (StreamKind::Wheels, Quantity::Angle),
                false if joints.has_speeds => (StreamKind::Wheels, Quantity::Speed),
                _ => return None,
            };
            quantity = Some(list);
            kind
        }
        _ => return None,
    };
    Some(Source {
        robot: robot_of_topic(&topic.channel.topic),
        kind,
        topic: topic.channel.topic.clone(),
        selector,
        quantity,
    })
}

/// The robot of a topic: the first of several parts, such as `r1` in `/r1/odom`, unless it names a
/// sensor.
fn robot_of_topic(topic: &str) -> String {
    let mut parts = topic.split('/').filter(|part| !part.is_empty());
    match (parts.next(), parts.next()) {
        (Some(robot), Some(_)) if !NOT_ROBOTS.contains(&robot) && is_robot_name(robot) => {
            robot.to_owned()
        }
        _ => "robot".to_owned(),
    }
}
