//! What a guess did not use although it might be a source.

use slipstream_bag::ros::Encoding;

use super::candidate::is_told;
use super::joints;
use super::meaning::Meaning;
use super::numbers::may_have_numbers;
use super::pairs::meaning_of;
use super::source::Source;
use super::survey::Topic;
use crate::decode::layout_of;
use crate::table::StreamKind;

/// So many sources are named.
const MOST: usize = 30;

/// What to say of what was not used, one entry each: `possible` are the sources that the guess chose from, `used` those that
/// it chose.
pub(super) fn notes(topics: &[Topic], possible: &[Source], used: &[Source]) -> Vec<String> {
    let mut notes = Vec::new();
    let mut unused: Vec<String> = possible
        .iter()
        .filter(|own| !used.contains(own))
        .map(|own| of_source(own, topics, used))
        .collect();
    notes.extend(undefined(topics));
    notes.extend(in_other_encodings(topics));
    let others = impossible(topics, possible);
    unused.extend(others.filter_map(|topic| of_topic(topic, used)));
    unused.sort();
    if let Some(listed) = list(unused) {
        notes.push(format!(
            "not used, though each might be a source: {listed}; map them with --topics"
        ));
    }
    notes
}

/// What to say of joints that may be the wheels, where no other wheels are used; one entry each.
pub(super) fn joints_without_sides(
    topics: &[Topic],
    possible: &[Source],
    used: &[Source],
) -> Vec<String> {
    if used.iter().any(|own| own.kind == StreamKind::Wheels) {
        return Vec::new();
    }
    let others = impossible(topics, possible);
    others.filter_map(joints::without_sides).collect()
}

/// The topics that the guess could not choose.
fn impossible<'a>(topics: &'a [Topic], possible: &[Source]) -> impl Iterator<Item = &'a Topic> {
    topics.iter().filter(|topic| {
        let name = topic.channel.topic.as_str();
        !possible.iter().any(|own| own.topics().contains(&name))
    })
}

/// A source that was not chosen.
fn of_source(source: &Source, topics: &[Topic], used: &[Source]) -> String {
    let mut same = topics.iter();
    let topic = same.find(|topic| topic.channel.topic == source.topic);
    let selector = &source.selector;
    let wheels = || {
        let names = selector.joints.iter().flatten();
        names.map(String::as_str).collect::<Vec<_>>().join(" and ")
    };
    let what = match topic {
        Some(topic) if topic.has_transforms() => match (&selector.parent, &selector.frame) {
            (Some(parent), Some(frame)) => format!("{parent} to {frame}"),
            _ => format!("the wheels {}", wheels()),
        },
        Some(topic) if !topic.numbers.is_empty() && source.apart.is_none() => wheels(),
        Some(topic) => format!("{}, {} messages", topic.type_name(), topic.messages),
        None => source.kind.name().to_owned(),
    };
    let name = source.topics().join(" and ");
    format!("{name} ({what}{})", instead(source.kind, used))
}

/// A topic that might have a stream, though no guess is sure which; `None` for what is no source.
fn of_topic(topic: &Topic, used: &[Source]) -> Option<String> {
    let kind = match by_type(topic, used) {
        Some(kind) => Some(kind),
        None => by_numbers(topic)?,
    };
    let (name, of, messages) = (&topic.channel.topic, topic.type_name(), topic.messages);
    let instead = kind.map_or_else(String::new, |kind| instead(kind, used));
    Some(format!("{name} ({of}, {messages} messages{instead})"))
}

/// The stream that messages of a type can give.
fn by_type(topic: &Topic, used: &[Source]) -> Option<StreamKind> {
    // Without other wheels, more is said of these.
    let has_other_wheels = used.iter().any(|own| own.kind == StreamKind::Wheels);
    let is_told = is_told(&topic.channel.topic.to_lowercase());
    Some(match topic.type_name() {
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
        "JointState" if has_other_wheels && !joints::turning(topic).is_empty() => {
            StreamKind::Wheels
        }
        of if of.starts_with("AckermannDrive") => StreamKind::Command,
        _ => return None,
    })
}

/// The stream that numbers may be by their names, or `None` in it where these tell no more than a side.
fn by_numbers(topic: &Topic) -> Option<Option<StreamKind>> {
    let varying = topic.numbers.iter().filter(|(_, seen)| seen.vary());
    let meanings = varying.map(|(path, _)| meaning_of(topic, path));
    let mut meanings: Vec<Meaning> = meanings.collect();
    meanings.retain(|own| *own != Meaning::Nothing);
    let all = |meaning| meanings.iter().all(|own| *own == meaning);
    match () {
        () if meanings.is_empty() => None,
        () if all(Meaning::Command) => Some(Some(StreamKind::Command)),
        () if all(Meaning::Side) => Some(None),
        () => Some(Some(StreamKind::Wheels)),
    }
}

/// The topics of which the bag does not say which fields their messages have.
fn undefined(topics: &[Topic]) -> Option<String> {
    let is_undefined = |topic: &&Topic| {
        let channel = &topic.channel;
        // Entries of a data log say in their type what they are.
        may_have_numbers(channel)
            && channel.encoding != "wpilog"
            && Encoding::of(&channel.encoding).is_some()
            && !channel.schema.starts_with("std_msgs/")
            && layout_of(channel).is_none()
    };
    let names = topics.iter().filter(is_undefined).map(|topic| {
        let (name, of, messages) = (&topic.channel.topic, topic.type_name(), topic.messages);
        format!("{name} ({of}, {messages} messages)")
    });
    let listed = list(names.collect())?;
    Some(format!(
        "not read, because the bag has no definition of their types: {listed}; if one has wheels, convert the bag to MCAP \
         (`ros2 bag convert`) where these types are installed"
    ))
}

/// The topics whose messages no reader here decodes.
fn in_other_encodings(topics: &[Topic]) -> Option<String> {
    let channels = topics.iter().map(|topic| &topic.channel);
    let others = channels.filter(|channel| Encoding::of(&channel.encoding).is_none());
    let names = others.map(|channel| match channel.encoding.as_str() {
        "" => channel.topic.clone(),
        encoding => format!("{} ({encoding})", channel.topic),
    });
    let listed = list(names.collect())?;
    Some(format!(
        "not read, because messages are neither in CDR nor in the encoding of ROS 1: {listed}"
    ))
}

/// The first of these, and how many more; `None` if there are none.
fn list(mut names: Vec<String>) -> Option<String> {
    let more = names.len().saturating_sub(MOST);
    names.truncate(MOST);
    if more > 0 {
        names.push(format!("{more} more"));
    }
    (!names.is_empty()).then(|| names.join(", "))
}

/// What is used for a stream.
fn instead(kind: StreamKind, used: &[Source]) -> String {
    let source = used.iter().find(|own| own.kind == kind);
    source.map_or_else(String::new, |own| {
        let verb = if own.apart.is_some() { "are" } else { "is" };
        format!("; {} {verb} used", own.topics().join(" and "))
    })
}
