//! The guess of a map as a file, to be corrected by a person.

use std::fmt::Write as _;

use slipstream_bag::{Bag, Result};

use super::chain::Chain;
use super::description::{WheelNames, descriptions};
use super::guess::{Guess, guess};
use super::numbers::may_have_numbers;
use super::survey::{Topic, survey};
use crate::decode::layout_of;

/// The guess of a map as text, with comments on the topics that it leaves out.
///
/// # Errors
/// If it is not a bag, or cannot be read.
pub(crate) fn draft_topics(bag: &dyn Bag, wheels: &WheelNames<'_>) -> Result<String> {
    let (topics, _) = survey(bag, &[])?;
    let Guess {
        map,
        left_out,
        notes,
    } = guess(&topics, &wheels.all(&descriptions(&topics)));
    let mut text = String::from(
        "# Which topic is which stream of which robot, as guessed. Correct it, then give it with --topics.\n",
    );
    for note in left_out.into_iter().chain(notes) {
        let _ = writeln!(text, "# {note}");
    }
    for source in &map.sources {
        let mut same = topics.iter();
        let topic = same.find(|topic| topic.channel.topic == source.topic);
        if let Some(chain) = topic.and_then(|topic| Chain::of(source, topic, &topics)) {
            let (kind, name) = (source.kind.name(), chain.name());
            let _ = writeln!(text, "# {}/{kind}: composed of {name}", source.robot);
        }
    }
    text.push_str(&map.to_text());
    let is_left_out = |topic: &&Topic| {
        let name = topic.channel.topic.as_str();
        map.sources.iter().all(|own| !own.topics().contains(&name))
    };
    let others: Vec<String> = topics.iter().filter(is_left_out).map(describe).collect();
    if !others.is_empty() {
        text.push_str("# Topics that are left out:\n");
        text.extend(others);
    }
    Ok(text)
}

/// A comment on a topic: its messages, joints, transforms and numbers.
fn describe(topic: &Topic) -> String {
    let (name, schema) = (&topic.channel.topic, &topic.channel.schema);
    let mut line = format!("# {name}: {} messages, {schema}", topic.messages);
    let mut fields: Vec<String> = topic.numbers.keys().cloned().collect();
    if fields.is_empty() && may_have_numbers(&topic.channel) {
        let layout = layout_of(&topic.channel);
        fields = layout.map_or_else(Vec::new, |layout| layout.number_paths());
    }
    let frames = topic.frames.keys();
    let frames = frames.map(|[parent, child]| format!("{parent} to {child}"));
    let parts: [(&str, Vec<String>); 3] = [
        ("joints", topic.joints.keys().cloned().collect()),
        ("transforms", frames.collect()),
        ("fields", fields),
    ];
    for (what, names) in parts.iter().filter(|(_, names)| !names.is_empty()) {
        // Writing to a string cannot fail.
        let _ = write!(line, ", {what} {}", names.join(", "));
    }
    line.push('\n');
    line
}
