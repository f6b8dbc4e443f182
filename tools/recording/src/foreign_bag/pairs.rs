//! Pairs of numbers that a guess takes for the wheels of a robot: in one message, or in a topic each.

use std::collections::BTreeMap;

use super::candidate::{Candidate, robot_of_topic, within_robot};
use super::meaning::{Meaning, has_other_unit, meaning};
use super::numbers::Numbers;
use super::source::{Place, Quantity, Source};
use super::survey::Topic;
use crate::decode::MessageSelector;
use crate::sides::{Side, side_and_rest};
use crate::table::StreamKind;

/// A number of one side.
struct Sided<'a> {
    topic: &'a Topic,
    path: &'a str,
    seen: &'a Numbers,
    meaning: Meaning,
    side: Side,
    rest: String,
}

/// What a number of a topic tells by its names.
pub(super) fn meaning_of(topic: &Topic, path: &str) -> Meaning {
    let name = within_robot(&topic.channel.topic);
    meaning(name, &topic.channel.schema, path)
}

/// The wheels that names and values tell, as streams.
pub(super) fn wheels(topics: &[Topic]) -> Vec<Candidate> {
    let all: Vec<Sided<'_>> = topics.iter().flat_map(sided).collect();
    let mut left = BTreeMap::new();
    for own in all.iter().filter(|own| own.side == Side::Left) {
        left.entry(own.rest.as_str()).or_insert(own);
    }
    let right = all.iter().filter(|own| own.side == Side::Right);
    let pairs = right.filter_map(|own| Some((own, *left.get(own.rest.as_str())?)));
    pairs
        .filter_map(|(right, left)| candidate(right, left))
        .collect()
}

fn sided(topic: &Topic) -> Vec<Sided<'_>> {
    let sided = topic.numbers.iter().filter_map(|(path, seen)| {
        let name = &topic.channel.topic;
        let (side, rest) = side_and_rest(&format!("{}/{path}", within_robot(name)))?;
        let rest = format!("{}: {rest}", robot_of_topic(name));
        Some(Sided {
            topic,
            path,
            seen,
            meaning: meaning_of(topic, path),
            side,
            rest,
        })
    });
    sided.collect()
}

/// The stream of two numbers, if it is sure what they are.
fn candidate(right: &Sided<'_>, left: &Sided<'_>) -> Option<Candidate> {
    let (quantity, rank) = quantity(right, left)?;
    let topic = &right.topic.channel.topic;
    let mut source = Source {
        quantity: Some(quantity),
        ..Source::of(&robot_of_topic(topic), StreamKind::Wheels, topic)
    };
    if *topic == left.topic.channel.topic {
        source.selector = MessageSelector {
            joints: [right, left].map(|own| vec![own.path.to_owned()]),
            ..MessageSelector::default()
        };
    } else {
        source.apart = Some([right, left].map(|own| Place {
            topic: own.topic.channel.topic.clone(),
            field: own.path.to_owned(),
        }));
    }
    Some(Candidate {
        source,
        rank,
        messages: right.topic.messages.min(left.topic.messages),
    })
}

/// What two numbers are, and how good a source; `None` where names and values do not tell.
fn quantity(right: &Sided<'_>, left: &Sided<'_>) -> Option<(Quantity, u32)> {
    let both = [right, left];
    let all = |has: fn(&Numbers) -> bool| both.iter().all(|own| has(own.seen));
    let any = |has: fn(&Numbers) -> bool| both.iter().any(|own| has(own.seen));
    let is_other = both
        .iter()
        .any(|own| has_other_unit(own.path) || has_other_unit(&own.topic.channel.topic));
    if right.meaning != left.meaning || is_other || !any(Numbers::vary) {
        return None;
    }
    let are_counts = all(|own| own.is_integer && own.count_on());
    match right.meaning {
        Meaning::Ticks if all(|own| own.are_whole) => Some((Quantity::Ticks, 4)),
        // An integer that counts on, as of `/lwheel`.
        Meaning::Wheel | Meaning::Angle if are_counts => Some((Quantity::Ticks, 4)),
        // Unlike ticks, angles need no count of a turn.
        Meaning::Angle if any(|own| !own.are_whole) => Some((Quantity::Angle, 5)),
        Meaning::Speed if any(|own| !own.are_whole) => Some((Quantity::Speed, 3)),
        _ => None,
    }
}
