//! The poses that a guess finds among transforms.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::candidate::{Candidate, is_of_reference, robot_of_topic};
use super::chain::links;
use super::frames::is_base;
use super::source::Source;
use super::survey::{Seen, Topic};
use crate::decode::MessageSelector;
use crate::table::StreamKind;

/// Transforms from a frame of the world to a robot's, where a reference measures them.
pub(super) fn poses(topic: &Topic, topics: &[Topic]) -> Vec<Candidate> {
    let mut poses = Vec::new();
    let carried = carried(topic, topics);
    // What never moves, such as `world` to `map`, is the pose of no robot.
    let of_world = |([parent, _], seen): &(&[String; 2], &Seen)| {
        seen.varies && is_of_reference(&parent.to_lowercase())
    };
    for ([parent, child], seen) in topic.frames.iter().filter(of_world) {
        if !is_odometry(child) {
            let frame = base_of(child, &carried);
            poses.push(candidate(topic, [parent, frame], seen, 1));
        } else {
            // Of `map` and `odom`, localisation computes the first from the second: a correction, which becomes a pose
            // together with the odometry. One that never changes leaves odometry alone.
            for frame in moving_children(child, topics) {
                poses.push(candidate(topic, [parent, frame], seen, 0));
            }
        }
    }
    poses
}

fn is_odometry(frame: &str) -> bool {
    frame.to_lowercase().contains("odom")
}

fn candidate(topic: &Topic, [parent, frame]: [&str; 2], seen: &Seen, rank: u32) -> Candidate {
    let robot = robot_of_topic(&format!("/{}", frame.trim_start_matches('/')));
    Candidate {
        source: Source {
            selector: MessageSelector {
                parent: Some(parent.to_owned()),
                frame: Some(frame.to_owned()),
                ..MessageSelector::default()
            },
            ..Source::of(&robot, StreamKind::Pose, &topic.channel.topic)
        },
        rank,
        messages: seen.count,
    }
}

/// Frames that never move, by the frame in which they do not.
type FixedFrames = BTreeMap<String, Vec<String>>;

fn carried(topic: &Topic, topics: &[Topic]) -> FixedFrames {
    let mut carried = FixedFrames::new();
    for (frames, link) in links(topics, &topic.channel.topic) {
        let [parent, child] = frames;
        if link.fixed.is_some() {
            carried.entry(parent).or_default().push(child);
        }
    }
    carried
}

/// The base of the robot, if `frame` is a marker or sensor that is fixed to it; else `frame`.
fn base_of<'a>(frame: &'a str, carried: &'a FixedFrames) -> &'a str {
    let mut reached = BTreeSet::from([frame]);
    let mut waiting = VecDeque::from([frame]);
    while let Some(here) = waiting.pop_front() {
        if is_base(here) {
            return here;
        }
        let children = carried.get(here).into_iter().flatten();
        let new = children.map(String::as_str);
        waiting.extend(new.filter(|child| reached.insert(child)));
    }
    frame
}

/// The frames that move in this one, such as a robot's base in that of its odometry.
fn moving_children<'a>(frame: &str, topics: &'a [Topic]) -> Vec<&'a String> {
    let all = topics.iter().flat_map(|topic| &topic.frames);
    let is_it = |(frames, seen): &(&[String; 2], &Seen)| frames[0] == frame && seen.varies;
    all.filter(is_it).map(|([_, child], _)| child).collect()
}
