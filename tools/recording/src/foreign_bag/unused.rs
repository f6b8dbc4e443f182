//! What a guess did not use although it might be a source.

use super::joints;
use super::meaning::{Meaning, meaning};
use super::numbers::may_have_numbers;
use super::pairs::meaning_of;
use super::source::Source;
use super::survey::Topic;
use crate::decode::layout_of;
use crate::table::StreamKind;

/// Words in topics of poses that a robot is told, or that a person gives.
const TOLD: [&str; 5] = ["goal", "initialpose", "target", "waypoint", "setpoint"];
/// So many sources are named.
const MOST: usize = 30;

/// What to say of what was not used, one entry each: `possible` are the sources that the guess chose from, `used` those that
/// it chose.
pub(super) fn notes(topics: &[Topic], possible: &[Source], used: &[Source]) -> Vec<String> {
    let mut notes = Vec::new();
    let mut unused = Vec::new();
    let has_wheels = used.iter().any(|own| own.kind == StreamKind::Wheels);
    for topic in topics {
        let name = topic.channel.topic.as_str();
        let is_used = used.iter().any(|own| own.topics().contains(&name));
        let without_sides = match is_used || has_wheels || is_possible(name, possible) {
            true => None,
            false => joints::without_sides(topic),
        };
        if let Some(note) = without_sides {
            notes.push(note);
        } else if is_used {
            unused.extend(beside(topic, possible, used));
        } else if let Some(kind) = may_be(topic, possible) {
            unused.push(describe(topic, kind, used));
        }
    }
    if !unused.is_empty() {
        let more = unused.len().saturating_sub(MOST);
        unused.truncate(MOST);
        if more > 0 {
            unused.push(format!("{more} more"));
        }
        notes.push(format!(
            "not used, though each might be a source: {}; map them with --topics",
            unused.join(", ")
        ));
    }
    notes
}

fn is_possible(topic: &str, possible: &[Source]) -> bool {
    possible.iter().any(|own| own.topics().contains(&topic))
}

/// The stream that a topic might have; `None` in it if it is not sure which. `None` for what is no source.
fn may_be(topic: &Topic, possible: &[Source]) -> Option<Option<StreamKind>> {
    let name = topic.channel.topic.as_str();
    let of_topic = possible.iter().find(|own| own.topics().contains(&name));
    if let Some(source) = of_topic {
        return Some(Some(source.kind));
    }
    let is_told = TOLD.iter().any(|word| name.to_lowercase().contains(word));
    let kind = match topic.type_name() {
        "Twist" => StreamKind::Command,
        "TwistStamped" | "TwistWithCovarianceStamped" | "Odometry" => StreamKind::Odometry,
        "Pose"
        | "PoseStamped"
        | "PoseWithCovarianceStamped"
        | "PointStamped"
        | "TransformStamped"
            if !is_told =>
        {
            StreamKind::Pose
        }
        "JointState" if !joints::turning(topic).is_empty() => StreamKind::Wheels,
        of if of.starts_with("AckermannDrive") => StreamKind::Command,
        _ => return may_be_numbers(topic),
    };
    Some(Some(kind))
}

/// As [`may_be`], of messages without a meaning of their own.
fn may_be_numbers(topic: &Topic) -> Option<Option<StreamKind>> {
    let channel = &topic.channel;
    let varying = topic.numbers.iter().filter(|(_, seen)| seen.vary());
    let meanings = varying.map(|(path, _)| meaning_of(topic, path));
    let mut meanings: Vec<Meaning> = meanings.collect();
    let is_own = may_have_numbers(channel) && !channel.schema.starts_with("std_msgs/");
    if is_own && layout_of(channel).is_none() {
        meanings.push(meaning(&channel.topic, &channel.schema, ""));
    }
    meanings.retain(|own| *own != Meaning::Nothing);
    let is_command = |own: &Meaning| *own == Meaning::Command;
    match meanings.as_slice() {
        [] => None,
        all if all.iter().all(is_command) => Some(Some(StreamKind::Command)),
        all if all.iter().all(|own| *own == Meaning::Side) => Some(None),
        _ => Some(Some(StreamKind::Wheels)),
    }
}

/// The wheels among the transforms of a topic that has another stream.
fn beside(topic: &Topic, possible: &[Source], used: &[Source]) -> Option<String> {
    let name = topic.channel.topic.as_str();
    let is_wheels = |own: &&Source| own.kind == StreamKind::Wheels && own.topics().contains(&name);
    if !topic.has_transforms() || used.iter().any(|own| is_wheels(&own)) {
        return None;
    }
    let wheels = possible.iter().find(is_wheels)?;
    let frames: Vec<&str> = wheels
        .selector
        .joints
        .iter()
        .flatten()
        .map(String::as_str)
        .collect();
    let instead = instead(StreamKind::Wheels, used);
    Some(format!(
        "{name} (the wheels {}{instead})",
        frames.join(" and ")
    ))
}

/// A topic with its type, the number of its messages, and what is used instead.
fn describe(topic: &Topic, kind: Option<StreamKind>, used: &[Source]) -> String {
    let (name, of, messages) = (&topic.channel.topic, topic.type_name(), topic.messages);
    let instead = kind.map_or_else(String::new, |kind| instead(kind, used));
    let is_unknown = topic.numbers.is_empty()
        && may_have_numbers(&topic.channel)
        && layout_of(&topic.channel).is_none();
    let unknown = match is_unknown {
        true => ", a type without its definition",
        false => "",
    };
    format!("{name} ({of}, {messages} messages{unknown}{instead})")
}

/// What is used for a stream.
fn instead(kind: StreamKind, used: &[Source]) -> String {
    let source = used.iter().find(|own| own.kind == kind);
    source.map_or_else(String::new, |own| {
        let verb = if own.apart.is_some() { "are" } else { "is" };
        format!("; {} {verb} used", own.topics().join(" and "))
    })
}
