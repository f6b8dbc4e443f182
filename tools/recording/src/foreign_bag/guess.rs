//! Guess of a topic map from the types, names and contents of the topics.

use slipstream_bag::ros::Encoding;

use super::candidate::{Candidate, has_word, is_of_reference, is_told, robot_of_topic};
use super::description::WheelJoints;
use super::frames::Frames;
use super::source::{Quantity, Source};
use super::survey::{Joint, Topic};
use super::topic_map::TopicMap;
use super::{joints, pairs, rolling, transforms, unused};
use crate::decode::MessageSelector;
use crate::table::StreamKind;

/// Words in topics of estimates that mix sensors, the wheels among them.
const MIXED: [&str; 4] = ["ekf", "ukf", "filtered", "combined"];

/// The guess of a map.
pub(super) struct Guess {
    pub(super) map: TopicMap,
    /// What it left out although it is likely a stream of a robot, one entry each.
    pub(super) left_out: Vec<String>,
    /// What else a person should know about it, one entry each.
    pub(super) notes: Vec<String>,
}

/// The most likely stream of each topic. Of several topics for one stream, the one of highest rank, then the one with
/// most messages. `known` are wheels that descriptions of robots name.
pub(super) fn guess(topics: &[Topic], known: &[WheelJoints]) -> Guess {
    let mut left_out = Vec::new();
    let mut candidates = Vec::new();
    let frames = Frames::of(topics);
    for topic in topics {
        let wheels = joints::wheels(&topic.joints, known, &frames);
        left_out.extend(without_values(topic, wheels.as_ref()));
        candidates.extend(candidate(topic, wheels));
        candidates.extend(transforms::poses(topic, topics));
    }
    candidates.extend(pairs::wheels(topics));
    candidates.extend(rolling::wheels(&frames));
    give_to_robots(&mut candidates, &mut left_out);
    let possible: Vec<Source> = candidates.iter().map(|own| own.source.clone()).collect();
    let mut best: Vec<Candidate> = Vec::new();
    for new in candidates {
        let is_same = |old: &&mut Candidate| {
            (&old.source.robot, old.source.kind) == (&new.source.robot, new.source.kind)
        };
        match best.iter_mut().find(is_same) {
            Some(old) if (old.rank, old.messages) < (new.rank, new.messages) => *old = new,
            Some(_) => {}
            None => best.push(new),
        }
    }
    best.sort_by(|a, b| (&a.source.robot, a.source.kind).cmp(&(&b.source.robot, b.source.kind)));
    let several = best.iter().filter_map(|own| several_wheels(&own.source));
    let mut notes: Vec<String> = several.collect();
    let sources: Vec<Source> = best.into_iter().map(|candidate| candidate.source).collect();
    left_out.extend(unused::joints_without_sides(topics, &possible, &sources));
    notes.extend(unused::notes(topics, &possible, &sources));
    Guess {
        map: TopicMap {
            sources,
            ..TopicMap::default()
        },
        left_out,
        notes,
    }
}

/// The most likely stream of a topic, if any.
fn candidate(topic: &Topic, wheels: Option<joints::Wheels>) -> Option<Candidate> {
    Encoding::of(&topic.channel.encoding)?;
    let name = topic.channel.topic.to_lowercase();
    let contains = |words: &[&str]| words.iter().any(|word| name.contains(word));
    let is_command = contains(&["cmd", "command", "target", "desired", "setpoint"]);
    let mut selector = MessageSelector::default();
    let mut quantity = None;
    let mut rank = 1;
    let kind = match topic.type_name() {
        "Twist" | "TwistStamped" | "struct:ChassisSpeeds" if is_command => {
            // What a multiplexer chooses from is not what the drives were told.
            rank = u32::from(!contains(&["input", "teleop", "joy", "key", "nav"]));
            StreamKind::Command
        }
        "TwistStamped" | "TwistWithCovarianceStamped" | "struct:ChassisSpeeds" => {
            StreamKind::Odometry
        }
        "Odometry" if is_reference(topic) => StreamKind::Pose,
        "Odometry" => {
            // Estimates that mix in other sensors are not those of the wheels.
            rank = u32::from(!contains(&MIXED));
            StreamKind::Odometry
        }
        "PoseStamped" | "PoseWithCovarianceStamped" | "struct:Pose2d"
            if name.contains("odom") && !is_reference(topic) =>
        {
            rank = 0;
            StreamKind::Odometry
        }
        "PoseStamped"
        | "PoseWithCovarianceStamped"
        | "TransformStamped"
        | "PointStamped"
        | "struct:Pose2d"
            if !contains(&MIXED) && !is_told(&name) =>
        {
            rank = pose_rank(topic);
            StreamKind::Pose
        }
        "Imu" => {
            rank = u32::from(!contains(&["raw"]));
            StreamKind::Imu
        }
        "EncoderTicks" => {
            rank = 9;
            StreamKind::Wheels
        }
        "WheelVoltage" => StreamKind::Command,
        "MotorState" => StreamKind::Motor,
        "JointState" => {
            let is_of_arm = |own: &joints::Wheels| !own.are_named && !joints::is_driven(&name);
            let wheels = wheels.filter(|own| !is_of_arm(own))?;
            selector = wheels.selector;
            let (kind, list) = list_of(topic, &selector, is_command)?;
            rank = match () {
                // Some publishers fill in zeros for what nothing measures.
                () if !turn(topic, &selector) => 0,
                () if kind == StreamKind::Command => 1,
                () if wheels.are_named => 8,
                () => 7,
            };
            quantity = Some(list);
            kind
        }
        _ => return None,
    };
    Some(Candidate {
        source: Source {
            selector,
            quantity,
            ..Source::of(
                &robot_of_topic(&topic.channel.topic),
                kind,
                &topic.channel.topic,
            )
        },
        rank,
        messages: topic.messages,
    })
}

/// Whether a wheel turns.
fn turn(topic: &Topic, selector: &MessageSelector) -> bool {
    let mut joints = selector.joints.iter().flatten();
    let turns = |joint: &Joint| joint.angle.vary || joint.speed.vary || joint.torque.vary;
    joints.any(|name| topic.joints.get(name).is_some_and(turns))
}

/// Which list of a joint state to read, and what it is: commands, or wheels.
fn list_of(
    topic: &Topic,
    selector: &MessageSelector,
    is_command: bool,
) -> Option<(StreamKind, Quantity)> {
    let wheels = || {
        let names = selector.joints.iter().flatten();
        names.filter_map(|name| topic.joints.get(name))
    };
    let all = |has: fn(&Joint) -> bool| wheels().all(has);
    // Some drivers fill the angles with zeros.
    let angles_move = wheels().any(|joint| joint.angle.vary);
    let speeds_move = wheels().any(|joint| joint.speed.vary);
    match is_command {
        true if all(|joint| joint.torque.any()) => Some((StreamKind::Command, Quantity::Torque)),
        true if all(|joint| joint.speed.any()) => Some((StreamKind::Command, Quantity::Speed)),
        true => None,
        false if all(|joint| joint.angle.any()) && (angles_move || !speeds_move) => {
            Some((StreamKind::Wheels, Quantity::Angle))
        }
        false if all(|joint| joint.speed.any()) => Some((StreamKind::Wheels, Quantity::Speed)),
        false => None,
    }
}

/// Whether an odometry message is a reference, and not the robot's own estimate.
fn is_reference(topic: &Topic) -> bool {
    let frame = topic.frame.as_deref().unwrap_or_default();
    [&topic.channel.topic, frame].iter().any(|name| {
        let name = name.to_lowercase();
        !name.contains("odom_combined") && is_of_reference(&name)
    })
}

/// How good a pose is as a reference: motion capture, then other poses, then localisation on a map.
fn pose_rank(topic: &Topic) -> u32 {
    let name = topic.channel.topic.to_lowercase();
    if ["amcl", "slam"].iter().any(|word| name.contains(word)) {
        return 1;
    }
    if is_of_reference(&name) { 3 } else { 2 }
}

/// How good the sort of source is: what is called a wheel, other joint states, numbers, transforms, what does not move.
fn sort(wheels: &Candidate) -> u32 {
    match wheels.rank {
        8.. => 4,
        7 => 3,
        3..7 => 2,
        rank => rank,
    }
}

/// Gives the streams of sensors outside of a robot, such as a camera's poses, to the robot that has wheels.
fn give_to_robots(candidates: &mut Vec<Candidate>, notes: &mut Vec<String>) {
    let robots_with = |kind: StreamKind| {
        let of_kind = || candidates.iter().filter(|c| c.source.kind == kind);
        // Wheels of a worse sort, whose names may begin otherwise, are those of the same robots.
        let best = of_kind().map(sort).max();
        let with = of_kind().filter(|own| kind != StreamKind::Wheels || Some(sort(own)) == best);
        let mut robots: Vec<String> = with.map(|c| c.source.robot.clone()).collect();
        robots.sort();
        robots.dedup();
        robots
    };
    let kinds = [
        StreamKind::Wheels,
        StreamKind::Odometry,
        StreamKind::Command,
    ];
    let robots = kinds
        .map(robots_with)
        .into_iter()
        .find(|robots| !robots.is_empty());
    let Some(robots) = robots else { return };
    candidates.retain_mut(|candidate| {
        let source = &mut candidate.source;
        let name = source.selector.frame.as_ref().unwrap_or(&source.topic);
        let named = robots
            .iter()
            .find(|robot| has_word(&name.to_lowercase(), &robot.to_lowercase()));
        match (robots.as_slice(), named) {
            ([only], _) => source.robot.clone_from(only),
            (_, Some(named)) => source.robot.clone_from(named),
            _ if robots.contains(&source.robot) => {}
            _ => {
                notes.push(format!(
                    "{name}: left out: its name does not tell which of the robots {} it belongs to",
                    robots.join(", ")
                ));
                return false;
            }
        }
        true
    });
}

/// What to say of joint states whose wheels have no values.
fn without_values(topic: &Topic, wheels: Option<&joints::Wheels>) -> Option<String> {
    let joints = &wheels?.selector.joints;
    let names: Vec<&str> = joints.iter().flatten().map(String::as_str).collect();
    let has_none = |name: &&str| {
        topic
            .joints
            .get(*name)
            .is_some_and(|joint| !(joint.angle.any() || joint.speed.any() || joint.torque.any()))
    };
    names.iter().all(has_none).then(|| {
        let (topic, names) = (&topic.channel.topic, names.join(", "));
        format!("{topic}: left out: {names} have neither angle, speed nor torque")
    })
}

/// What to say of wheels that are the mean of several.
fn several_wheels(source: &Source) -> Option<String> {
    let [right, left] = &source.selector.joints;
    (source.quantity.is_some() && right.len() > 1).then(|| {
        format!(
            "{}: {} wheels: the right side is the mean of {}, the left side that of {}",
            source.topic,
            right.len() + left.len(),
            right.join(" and "),
            left.join(" and ")
        )
    })
}
