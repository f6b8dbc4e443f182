//! Why streams of a bag cannot be read, with the remedies.

use std::collections::BTreeSet;
use std::path::Path;

use slipstream_bag::Loss;
use slipstream_bus::InputError;

use super::chain::Chain;
use super::source::Source;
use super::survey::Topic;
use crate::decode::StreamBuilder;
use crate::table::StreamKind;

/// Why the guess finds nothing.
pub(super) fn no_stream(path: &Path, topics: &[Topic], loss: &Loss) -> InputError {
    if topics.is_empty() {
        let problem = match loss.any() {
            true => format!("has no messages that can be read: {loss}"),
            false => "has no messages".to_owned(),
        };
        return InputError::file(path, problem, "give a bag with messages");
    }
    let names = topics.iter().take(20).map(|topic| {
        let (name, schema) = (&topic.channel.topic, &topic.channel.schema);
        format!("{name} ({schema}, {})", topic.channel.encoding)
    });
    let names: Vec<String> = names.collect();
    let problem = format!(
        "no topic looks like a stream of a robot: {}",
        names.join(", ")
    );
    let remedy = "say which topic is which stream in a map for --topics; `slipstream check BAG --write-topics \
                  FILE.toml` writes one to be completed";
    InputError::file(path, problem, remedy)
}

/// What is wrong with a stream that was read, and the remedy.
pub(super) fn problem(
    source: &Source,
    stream: &StreamBuilder,
    topics: &[Topic],
) -> Option<(String, String)> {
    let topic = topics
        .iter()
        .find(|topic| topic.channel.topic == source.topic)?;
    let (name, kind) = (&source.topic, source.kind.name());
    let missing = missing_joints(source, topic);
    if !missing.is_empty() {
        let known: Vec<&str> = topic.joints.keys().map(String::as_str).collect();
        let problem = format!("{name} has no joint {}", missing.join(", "));
        return Some((problem, format!("name one of: {}", known.join(", "))));
    }
    if let Some(missing) = missing_field(source, topics) {
        return Some(missing);
    }
    let is_pose = source.kind == StreamKind::Pose;
    if stream.is_empty() && topic.has_transforms() && is_pose {
        return Some(no_transform(source, topics));
    }
    let empty = stream.empty_columns();
    if empty.is_empty() {
        return None;
    }
    let problem = format!("{name} gives no value for {} of {kind}", empty.join(", "));
    let remedy = "map another topic or quantity, or leave the stream out";
    Some((problem, remedy.to_owned()))
}

/// Why no transforms give a pose, and the remedy.
fn no_transform(source: &Source, topics: &[Topic]) -> (String, String) {
    let (name, kind) = (&source.topic, source.kind.name());
    let all = topics.iter().flat_map(|topic| topic.frames.keys());
    let all: BTreeSet<String> = all
        .map(|[parent, child]| format!("{parent} to {child}"))
        .collect();
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    let remedy = format!(
        "name a parent and a frame between which these lead: {}",
        all.join(", ")
    );
    let ends = source.selector.parent.as_ref();
    let Some((parent, frame)) = ends.zip(source.selector.frame.as_ref()) else {
        return (format!("{name} has no such transform for {kind}"), remedy);
    };
    let problem = match Chain::find(topics, name, parent, frame) {
        None => format!("{name} has no transforms that lead from {parent} to {frame} for {kind}"),
        Some(chain) if chain.moving_topics().is_empty() => {
            format!("{name}: nothing moves between {parent} and {frame}")
        }
        Some(_) => format!(
            "{name}: the transforms that lead from {parent} to {frame} have no time in common"
        ),
    };
    (problem, remedy)
}

/// The joints of a map that the topic does not have.
fn missing_joints(source: &Source, topic: &Topic) -> Vec<String> {
    if topic.type_name() != "JointState" {
        return Vec::new();
    }
    let joints = source.selector.joints.iter().flatten();
    let missing = joints.filter(|joint| !topic.joints.contains_key(*joint));
    missing.cloned().collect()
}

/// A field of a map that the messages of its topic do not have, and the remedy.
fn missing_field(source: &Source, topics: &[Topic]) -> Option<(String, String)> {
    const MOST: usize = 40;
    let in_one = source.selector.joints.iter().flatten();
    let places: Vec<(&str, &str)> = match &source.apart {
        Some(places) => places
            .iter()
            .map(|own| (&*own.topic, &*own.field))
            .collect(),
        None => in_one.map(|field| (&*source.topic, &**field)).collect(),
    };
    places.into_iter().find_map(|(name, field)| {
        let topic = topics.iter().find(|topic| topic.channel.topic == name)?;
        if topic.numbers.is_empty() || topic.numbers.contains_key(field) {
            return None;
        }
        let known: Vec<&str> = topic
            .numbers
            .keys()
            .take(MOST)
            .map(String::as_str)
            .collect();
        let problem = format!("{name} has no field {field}");
        Some((problem, format!("name one of: {}", known.join(", "))))
    })
}
