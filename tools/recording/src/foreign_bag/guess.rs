//! Guesses which topic is which stream from types and names.

use super::survey::{Topic, wheel_joints};
use super::topic_map::{Quantity, Source, TopicMap};
use crate::decode::Pick;
use crate::recording::is_robot_name;
use crate::table::StreamKind;

/// What each topic most likely is. Of several that could be the same stream, the one with most
/// messages.
pub(super) fn guess(topics: &[Topic]) -> TopicMap {
    let mut candidates: Vec<(u64, Source)> = Vec::new();
    for topic in topics.iter().filter(|topic| topic.info.encoding == "cdr") {
        if let Some(source) = guess_one(topic) {
            let same = |(_, other): &&mut (u64, Source)| {
                (&other.robot, other.kind) == (&source.robot, source.kind)
            };
            match candidates.iter_mut().find(same) {
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

fn guess_one(topic: &Topic) -> Option<Source> {
    let name = topic.info.topic.to_lowercase();
    let any = |words: &[&str]| words.iter().any(|word| name.contains(word));
    let is_command = any(&["cmd", "command", "target", "desired", "setpoint"]);
    let is_truth = any(&[
        "truth",
        "mocap",
        "vicon",
        "optitrack",
        "gt",
        "pose",
        "camera",
    ]);
    let (kind, pick, quantity) = match (topic.info.schema.rsplit('/').next()?, &topic.joints) {
        ("Twist" | "TwistStamped", _) if is_command => (StreamKind::Command, Pick::default(), None),
        ("TwistStamped", _) => (StreamKind::Odometry, Pick::default(), None),
        ("Odometry", _) if is_truth => (StreamKind::Pose, Pick::default(), None),
        ("Odometry", _) => (StreamKind::Odometry, Pick::default(), None),
        ("PoseStamped" | "PoseWithCovarianceStamped", _) => {
            (StreamKind::Pose, Pick::default(), None)
        }
        ("Imu", _) => (StreamKind::Imu, Pick::default(), None),
        ("EncoderTicks", _) => (StreamKind::Wheels, Pick::default(), None),
        ("JointState", Some(joints)) => {
            let pick = wheel_joints(&joints.names)?;
            let (kind, quantity) = match is_command {
                true if joints.has_torques => (StreamKind::Command, Quantity::Torque),
                true if joints.has_speeds => (StreamKind::Command, Quantity::Speed),
                false if joints.has_angles => (StreamKind::Wheels, Quantity::Angle),
                false if joints.has_speeds => (StreamKind::Wheels, Quantity::Speed),
                _ => return None,
            };
            (kind, pick, Some(quantity))
        }
        _ => return None,
    };
    Some(Source {
        robot: robot_of(&topic.info.topic),
        kind,
        topic: topic.info.topic.clone(),
        pick,
        quantity,
    })
}

/// A topic's robot: its first part where it has several, such as `r1` of `/r1/odom`. Parts that
/// name a sensor and not a robot do not count.
fn robot_of(topic: &str) -> String {
    const SENSORS: [&str; 12] = [
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
    let mut parts = topic.split('/').filter(|part| !part.is_empty());
    match (parts.next(), parts.next()) {
        (Some(robot), Some(_)) if !SENSORS.contains(&robot) && is_robot_name(robot) => {
            robot.to_owned()
        }
        _ => "robot".to_owned(),
    }
}
