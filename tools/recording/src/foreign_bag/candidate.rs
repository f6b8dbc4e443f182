//! What a guess may choose: a stream that a topic may hold, of which robot.

use super::source::Source;
use crate::recording::is_robot_name;
use crate::sides::{side_of, words_of};

/// First parts of a topic that name a sensor or driver, not a robot.
const NOT_ROBOTS: [&str; 18] = [
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
    "ground_truth",
    "drive",
    "drivetrain",
    "smartdashboard",
    "realoutputs",
    "robotcontainer",
];

/// Words in topics and frames of references outside of the robot.
const REFERENCE: [&str; 10] = [
    "truth",
    "mocap",
    "vicon",
    "optitrack",
    "qualisys",
    "natnet",
    "vrpn",
    "gt",
    "world",
    "map",
];

/// Words in topics of poses that a robot is told, or that a person or planner gives.
const TOLD: [&str; 8] = [
    "goal",
    "initialpose",
    "target",
    "waypoint",
    "setpoint",
    "clicked",
    "lookahead",
    "carrot",
];

/// A stream that a topic may hold.
pub(super) struct Candidate {
    pub(super) source: Source,
    /// Higher for a better source of the same stream.
    pub(super) rank: u32,
    pub(super) messages: u64,
}

/// Whether a name has the word of a reference outside of the robot. It is in lower case.
pub(super) fn is_of_reference(name: &str) -> bool {
    REFERENCE.iter().any(|word| has_word(name, word))
}

/// Whether the poses of a topic are no measurement. Its name is in lower case.
pub(super) fn is_told(name: &str) -> bool {
    TOLD.iter().any(|word| name.contains(word))
}

/// Whether one of a name's words begins with `word`.
pub(super) fn has_word(name: &str, word: &str) -> bool {
    let mut words = name.split(|c: char| !c.is_ascii_alphanumeric());
    words.any(|own| own == word || (word.len() > 3 && own.starts_with(word)))
}

/// Whether a part of a topic names a wheel or its sensor, as in `/encoder/left`.
fn is_of_wheel(part: &str) -> bool {
    let is_it = |word: &String| {
        let words = ["wheel", "encoder", "tick", "motor"];
        words.iter().any(|known| word.contains(known))
    };
    // `r1` is a robot.
    let has_digit = part.chars().any(|c| c.is_ascii_digit());
    (side_of(part).is_some() && !has_digit) || words_of(part).iter().any(is_it)
}

/// A topic without the part that names its robot.
pub(super) fn within_robot(topic: &str) -> &str {
    let inner = topic
        .trim_start_matches('/')
        .strip_prefix(&robot_of_topic(topic));
    inner.filter(|own| own.starts_with('/')).unwrap_or(topic)
}

/// The robot of a topic: the first of several parts, such as `r1` in `/r1/odom`, unless it names a
/// sensor or a wheel.
pub(super) fn robot_of_topic(topic: &str) -> String {
    let mut parts = topic.split('/').filter(|part| !part.is_empty());
    match (parts.next(), parts.next()) {
        (Some(robot), Some(_))
            if !NOT_ROBOTS.contains(&robot.to_lowercase().as_str())
                && !is_of_wheel(robot)
                && is_robot_name(robot) =>
        {
            robot.to_owned()
        }
        _ => "robot".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_is_told_from_its_wheels_and_sensors() {
        let cases = [
            ("/r1/lwheel", "r1", "/lwheel"),
            ("/left_ticks", "robot", "/left_ticks"),
            ("/encoder/left", "robot", "/encoder/left"),
            ("/wheel/left/ticks", "robot", "/wheel/left/ticks"),
            ("/right/ticks", "robot", "/right/ticks"),
            ("/robot/ticks", "robot", "/ticks"),
            ("/Drive/LeftPositionRad", "robot", "/Drive/LeftPositionRad"),
        ];
        for (topic, robot, inner) in cases {
            assert_eq!(
                (robot_of_topic(topic).as_str(), within_robot(topic)),
                (robot, inner)
            );
        }
    }
}
