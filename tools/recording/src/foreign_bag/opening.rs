//! The streams of a map before the first message: what of which topic becomes which columns.

use std::path::Path;

use slipstream_bus::InputError;

use super::apart::{Apart, Take};
use super::chain::Chain;
use super::composed::Composed;
use super::frames::Frames;
use super::reading::{Reading, Way};
use super::rolling;
use super::source::{Quantity, Source};
use super::survey::Topic;
use super::topic_map::TopicMap;
use crate::decode::{Fields, Sample, StreamBuilder};
use crate::rows::Disk;
use crate::table::StreamKind;

/// Opens the streams of a map.
struct StreamOpening<'a> {
    disk: &'a Disk,
    path: &'a Path,
    topics: &'a [Topic],
    frames: Frames<'a>,
}

type Result<T> = std::result::Result<T, InputError>;

/// An empty stream for each entry of the map.
///
/// # Errors
/// If a topic, frame or field does not exist, or cannot provide the stream.
pub(super) fn open_streams(
    disk: &Disk,
    path: &Path,
    map: &TopicMap,
    topics: &[Topic],
) -> Result<Vec<Reading>> {
    let opening = StreamOpening {
        disk,
        path,
        topics,
        frames: Frames::of(topics),
    };
    let sources = map.sources.iter();
    sources.map(|source| opening.reading(source)).collect()
}

impl StreamOpening<'_> {
    fn reading(&self, source: &Source) -> Result<Reading> {
        let (columns, way) = match &source.apart {
            Some(_) => self.apart(source)?,
            None => self.one_topic(source)?,
        };
        let columns: Vec<String> = columns.iter().map(|&name| name.to_owned()).collect();
        let stream = StreamBuilder::new(self.disk, &source.robot, source.kind, &columns, &[]);
        let mut stream = stream.map_err(|e| InputError::file(self.path, e, "map another topic"))?;
        stream.selector = source.selector.clone();
        stream.reversed = source.reversed;
        Ok(Reading {
            source: source.clone(),
            stream,
            way,
        })
    }

    fn topic(&self, name: &str) -> Result<&Topic> {
        let mut topics = self.topics.iter();
        topics
            .find(|topic| topic.channel.topic == name)
            .ok_or_else(|| {
                let names = self.topics.iter().map(|own| own.channel.topic.as_str());
                let names: Vec<&str> = names.collect();
                let remedy = format!("name one of: {}", names.join(", "));
                InputError::file(self.path, format!("has no topic {name}"), remedy)
            })
    }

    /// A stream whose messages come from one topic.
    fn one_topic(&self, source: &Source) -> Result<(&'static [&'static str], Way)> {
        let topic = self.topic(&source.topic)?;
        let Some(columns) = source.columns(&topic.channel.schema) else {
            return self.fields(source, topic);
        };
        let way = if source.kind == StreamKind::Wheels && topic.has_transforms() {
            self.turning(source)?
        } else {
            match Chain::of(source, topic, self.topics) {
                Some(chain) => Way::Composed(Box::new(Composed::new(chain, self.disk))),
                None => Way::Messages,
            }
        };
        Ok((columns, way))
    }

    /// Wheels whose frames turn.
    fn turning(&self, source: &Source) -> Result<Way> {
        let take = |names: &Vec<String>| {
            let [name] = names.as_slice() else {
                let problem = format!("{} has several frames of one side", source.topic);
                return Err(InputError::file(
                    self.path,
                    problem,
                    "name one of each side",
                ));
            };
            let taken = rolling::take(&self.frames, name, source.selector.parent.as_deref());
            taken.map_err(|(problem, remedy)| {
                let problem = format!("{}: {problem}", source.topic);
                InputError::file(self.path, problem, remedy)
            })
        };
        let [right, left] = source.selector.joints.each_ref().map(take);
        let apart = Apart::new([right?, left?], Quantity::Angle, self.disk);
        Ok(Way::Apart(Box::new(apart)))
    }

    /// Two wheels as numbers of one message.
    fn fields(&self, source: &Source, topic: &Topic) -> Result<(&'static [&'static str], Way)> {
        let columns = self.columns(source, topic)?;
        let fields = Fields::new(&topic.channel, source.selector.joints.clone());
        let fields = fields.ok_or_else(|| self.cannot(source, topic))?;
        Ok((columns, Way::Fields(Box::new(fields))))
    }

    /// Two wheels with a topic each.
    fn apart(&self, source: &Source) -> Result<(&'static [&'static str], Way)> {
        let Some([right, left]) = &source.apart else {
            return self.one_topic(source);
        };
        let mut columns: &'static [&'static str] = &[];
        let mut take = |topic: &str, field: &str| {
            let topic = self.topic(topic)?;
            columns = self.columns(source, topic)?;
            let fields = Fields::new(&topic.channel, [vec![field.to_owned()], Vec::new()]);
            let fields = fields.ok_or_else(|| self.cannot(source, topic))?;
            Ok((topic.channel.topic.clone(), Take::Field(Box::new(fields))))
        };
        let wheels: [(String, Take); 2] = [
            take(&right.topic, &right.field)?,
            take(&left.topic, &left.field)?,
        ];
        let quantity = source.quantity.unwrap_or(Quantity::Angle);
        let apart = Apart::new(wheels, quantity, self.disk);
        Ok((columns, Way::Apart(Box::new(apart))))
    }

    /// The columns of numbers of a topic.
    fn columns(&self, source: &Source, topic: &Topic) -> Result<&'static [&'static str]> {
        let is_of_wheels = matches!(source.kind, StreamKind::Wheels | StreamKind::Command);
        if !is_of_wheels || Sample::can_be_of(&topic.channel) {
            return Err(self.cannot(source, topic));
        }
        source.columns_of_fields().ok_or_else(|| {
            let name = &topic.channel.topic;
            let kind = source.kind.name();
            let problem = format!("{name} has numbers, and the map no quantity that {kind} has");
            let remedy = match source.kind {
                StreamKind::Wheels => "add quantity = \"ticks\", \"angle\" or \"speed\"",
                _ => "add quantity = \"speed\", \"torque\" or \"voltage\"",
            };
            InputError::file(self.path, problem, remedy)
        })
    }

    fn cannot(&self, source: &Source, topic: &Topic) -> InputError {
        let (name, kind, schema) = (
            &topic.channel.topic,
            source.kind.name(),
            &topic.channel.schema,
        );
        let problem = format!("{name} is a {schema}, which cannot provide {kind}");
        InputError::file(self.path, problem, "map another topic")
    }
}
