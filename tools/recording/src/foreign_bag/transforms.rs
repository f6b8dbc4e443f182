//! The poses that a guess finds among transforms.

use super::candidate::{Candidate, is_of_reference, robot_of_topic};
use super::chain::Chain;
use super::survey::{Seen, Topic};
use super::topic_map::Source;
use crate::decode::MessageSelector;
use crate::table::StreamKind;

/// Transforms from a frame of the world to a robot's, where a reference measures them.
pub(super) fn poses(topic: &Topic, topics: &[Topic]) -> Vec<Candidate> {
    let mut poses = Vec::new();
    let of_world = |([parent, _], seen): &(&[String; 2], &Seen)| {
        seen.count > 1 && is_of_reference(&parent.to_lowercase())
    };
    for ([parent, child], seen) in topic.frames.iter().filter(of_world) {
        if !is_odometry(child) {
            let frame = carried_base(topic, [parent, child], topics);
            poses.push(candidate(topic, [parent, &frame], seen, 1));
        } else if seen.varies {
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
    Candidate {
        source: Source {
            robot: robot_of_topic(&format!("/{}", frame.trim_start_matches('/'))),
            kind: StreamKind::Pose,
            topic: topic.channel.topic.clone(),
            selector: MessageSelector {
                parent: Some(parent.to_owned()),
                frame: Some(frame.to_owned()),
                ..MessageSelector::default()
            },
            quantity: None,
        },
        rank,
        messages: seen.count,
    }
}

/// The base of the robot, if `child` is a marker or sensor that is fixed to it; else `child`.
fn carried_base(topic: &Topic, [parent, child]: [&String; 2], topics: &[Topic]) -> String {
    let is_base = |frame: &&String| {
        let name = frame.rsplit('/').next().unwrap_or_default();
        name == "base_link" || name == "base_footprint"
    };
    if is_base(&child) {
        return child.clone();
    }
    let children = topics.iter().flat_map(|topic| topic.frames.keys());
    let mut bases = children.map(|[_, child]| child).filter(is_base);
    let is_carried = |base: &&String| {
        let chain = Chain::find(topics, &topic.channel.topic, parent, base);
        let links = chain.map(|chain| chain.links).unwrap_or_default();
        let carried = links.split_first().is_some_and(|(first, others)| {
            first.frames.each_ref() == [parent, child]
                && others.iter().all(|link| link.fixed.is_some())
        });
        carried && links.len() > 1
    };
    bases.find(is_carried).unwrap_or(child).clone()
}

/// The frames that move in this one, such as a robot's base in that of its odometry.
fn moving_children<'a>(frame: &str, topics: &'a [Topic]) -> Vec<&'a String> {
    let all = topics.iter().flat_map(|topic| &topic.frames);
    let is_it = |(frames, seen): &(&[String; 2], &Seen)| frames[0] == frame && seen.varies;
    all.filter(is_it).map(|([_, child], _)| child).collect()
}
