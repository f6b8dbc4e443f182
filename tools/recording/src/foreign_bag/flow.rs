//! A bag of another robot that does not end: what its topics are is learnt once, and kept.

use std::collections::BTreeSet;
use std::path::PathBuf;

use slipstream_bag::{Bag, ChannelInfo, VisitResult};
use slipstream_bus::InputError;

use super::chain::Chain;
use super::clock::Clock;
use super::description::{InBag, WheelNames, descriptions};
use super::guess::guess;
use super::idle::idle_twists;
use super::opening::open_streams;
use super::problems::no_stream;
use super::reader::{clock, description};
use super::reading::{Reading, Way};
use super::source::Source;
use super::survey::{Topic, survey};
use super::topic_map::TopicMap;
use crate::recording::Recording;
use crate::rows::{Disk, SpooledRecording};
use crate::table::StreamKind;

/// The streams of a bag that does not end.
pub(crate) struct ForeignFlow {
    path: PathBuf,
    /// The user's map, if there is one.
    map: Option<TopicMap>,
    /// The map of the streams that are read.
    known: TopicMap,
    streams: Vec<Reading>,
    clock: Option<Clock>,
    /// The recording without rows.
    description: Recording,
    /// The topics of which it is known what they are, or that they are nothing.
    surveyed: BTreeSet<String>,
    /// Where rows go until they are passed on.
    disk: Disk,
}

/// What was learnt of topics.
pub(crate) struct Learnt {
    /// What a person should know.
    pub(crate) notes: Vec<String>,
    /// The descriptions of robots.
    pub(crate) described: Vec<InBag>,
    /// The index of the first stream that is new.
    pub(crate) first_new: usize,
}

/// Whether topics have told what they are.
pub(crate) enum Learning {
    /// They have.
    Learnt(Learnt),
    /// None is a stream, for this reason.
    Nothing(InputError),
}

impl ForeignFlow {
    /// Nothing is known yet.
    pub(crate) fn new(path: PathBuf, map: Option<TopicMap>) -> Self {
        let known = TopicMap {
            sources: Vec::new(),
            ..map.clone().unwrap_or_default()
        };
        Self {
            path,
            map,
            known,
            streams: Vec::new(),
            clock: None,
            description: Recording::default(),
            surveyed: BTreeSet::new(),
            disk: Disk::default(),
        }
    }

    /// The recording without rows.
    pub(crate) fn description(&mut self) -> &mut Recording {
        &mut self.description
    }

    /// The user's map, if there is one.
    pub(crate) fn map(&self) -> Option<&TopicMap> {
        self.map.as_ref()
    }

    /// Whether it is known what a topic is.
    pub(crate) fn knows(&self, topic: &str) -> bool {
        self.surveyed.contains(topic)
    }

    /// Whether any stream is known.
    pub(crate) fn has_streams(&self) -> bool {
        !self.streams.is_empty()
    }

    /// Learns which streams the topics of a bag are. Those that are known remain what they are.
    ///
    /// # Errors
    /// If a topic of the map cannot provide its stream.
    pub(crate) fn learn(
        &mut self,
        bag: &dyn Bag,
        wheels: &WheelNames<'_>,
    ) -> Result<Learning, InputError> {
        let mapped = self.map.as_ref().map_or_else(Vec::new, TopicMap::topics);
        let (mut topics, loss) = survey(bag, &mapped)?;
        let described = descriptions(&topics);
        let mut notes = Vec::new();
        let found = match &self.map {
            Some(map) => map.clone(),
            None => {
                let guess = guess(&topics, &wheels.all(&described));
                notes.extend(guess.notes.into_iter().chain(guess.left_out));
                guess.map
            }
        };
        let new = TopicMap {
            sources: self.new_sources(&found, &topics),
            ..self.known.clone()
        };
        if new.sources.is_empty() && !self.has_streams() {
            let guessed = no_stream(&self.path, &topics, &loss);
            return Ok(Learning::Nothing(self.nothing(&found, &topics, guessed)));
        }
        if self.map.is_none() && !new.sources.is_empty() {
            let sources = new.sources.iter().map(in_words);
            let sources: Vec<String> = sources.collect();
            let text = format!(
                "guessed topics: {}; to correct it: --topics",
                sources.join(", ")
            );
            notes.insert(0, text);
        }
        notes.extend(self.awaited(&found, &topics));
        // What stood still so far may move later.
        for topic in topics.iter_mut().filter(|own| !is_static(own)) {
            let frames = topic.frames.values_mut();
            frames.for_each(|seen| seen.varies |= seen.count > 1);
        }
        let mut streams = open_streams(&self.disk, &self.path, &new, &topics)?;
        notes.extend(idle_twists(&mut streams, &topics));
        let clock = match self.clock {
            Some(clock) => clock,
            None => *self
                .clock
                .insert(clock(&new, &streams, &topics, &mut notes)),
        };
        let first_new = self.streams.len();
        self.streams.extend(streams);
        self.known.sources.extend(new.sources);
        let model = self.description.model.take();
        self.description = description(&self.path, &self.known, clock);
        self.description.model = model;
        let names = topics.into_iter().map(|own| own.channel.topic.clone());
        self.surveyed.extend(names);
        Ok(Learning::Learnt(Learnt {
            notes,
            described,
            first_new,
        }))
    }

    /// Takes what a message has of the streams from the index `first` on.
    pub(crate) fn message(
        &mut self,
        first: usize,
        channel: &ChannelInfo,
        log_ns: i64,
        data: &[u8],
    ) -> VisitResult {
        let Some(clock) = self.clock else {
            return Ok(());
        };
        let streams = self.streams.iter_mut().skip(first);
        let pushed = streams.map(|reading| reading.push(channel, data, clock, log_ns));
        // All of them, even after one that fails.
        pushed.fold(Ok(()), VisitResult::and)
    }

    /// The rows that are complete. `is_broken`: what follows does not continue them, so that nothing waits for it.
    pub(crate) fn pass_on(&mut self, is_broken: bool, notes: &mut Vec<String>) -> SpooledRecording {
        let next = Disk::default();
        let disk = std::mem::replace(&mut self.disk, next.clone());
        let mut recording = SpooledRecording::new(self.description.clone(), disk);
        for Reading { stream, way, .. } in &mut self.streams {
            match way {
                Way::Messages | Way::Fields(_) => {}
                Way::Composed(own) if is_broken => own.break_off(stream, &next),
                Way::Composed(own) => own.pass_on(stream, &next),
                Way::Apart(own) if is_broken => own.break_off(stream, &next),
                Way::Apart(own) => own.pass_on(stream, &next),
            }
            stream.pass_on(&mut recording, notes, &next);
        }
        recording
    }

    /// The streams of a map that are not read yet, and whose topics and transforms are there.
    fn new_sources(&self, found: &TopicMap, topics: &[Topic]) -> Vec<Source> {
        let known = &self.known.sources;
        let is_new = |new: &&Source| {
            let mut all = known.iter();
            all.all(|own| (&own.robot, own.kind) != (&new.robot, new.kind)) && is_there(new, topics)
        };
        found.sources.iter().filter(is_new).cloned().collect()
    }

    /// What a map names and nothing has sent yet, if anything.
    fn awaited(&self, map: &TopicMap, topics: &[Topic]) -> Option<String> {
        let is_there = |name: &str| topics.iter().any(|own| own.channel.topic == name);
        let mut names = map.topics();
        names.retain(|name| !self.surveyed.contains(*name) && !is_there(name));
        (!names.is_empty()).then(|| format!("no messages yet of {}", names.join(", ")))
    }

    /// Why no stream is known.
    fn nothing(&self, found: &TopicMap, topics: &[Topic], guessed: InputError) -> InputError {
        if self.map.is_none() || topics.is_empty() {
            return guessed;
        }
        let names: Vec<&str> = topics
            .iter()
            .map(|own| own.channel.topic.as_str())
            .collect();
        let problem = format!("has no topic {}", found.topics().join(", "));
        let remedy = format!("name one of: {}", names.join(", "));
        InputError::file(&self.path, problem, remedy)
    }
}

/// Whether the topics of a stream are there; of a pose from transforms, those that lead to it.
fn is_there(source: &Source, topics: &[Topic]) -> bool {
    let topic = |name: &str| topics.iter().find(|own| own.channel.topic == name);
    let has_pose = || {
        let ends = (&source.selector.parent, &source.selector.frame);
        let (Some(parent), Some(frame), Some(topic)) = (ends.0, ends.1, topic(&source.topic))
        else {
            return true;
        };
        !topic.has_transforms() || Chain::find(topics, &source.topic, parent, frame).is_some()
    };
    let are_all = source.topics().iter().all(|name| topic(name).is_some());
    are_all && (source.kind != StreamKind::Pose || has_pose())
}

fn is_static(topic: &Topic) -> bool {
    topic.channel.topic.ends_with("tf_static")
}

/// A stream and where it comes from.
fn in_words(source: &Source) -> String {
    let (robot, kind) = (&source.robot, source.kind.name());
    format!("{robot}/{kind} from {}", source.topics().join(" and "))
}
