//! The way from one frame to another along transforms, where no single one leads there.

use std::collections::{BTreeMap, VecDeque};

use super::rigid::Rigid;
use super::source::Source;
use super::survey::Topic;

/// Transforms that lead from one frame to another, one after the other.
#[derive(Debug)]
pub(super) struct Chain {
    pub(super) links: Vec<Link>,
}

/// A transform of a chain.
#[derive(Debug, Clone)]
pub(super) struct Link {
    /// Parent and child.
    pub(super) frames: [String; 2],
    /// The topic that has it.
    pub(super) topic: String,
    /// The chain leads from the child to the parent.
    pub(super) is_inverse: bool,
    /// The child in the parent, if it never moves there.
    pub(super) fixed: Option<Rigid>,
}

impl Link {
    /// Its name in a sentence.
    pub(super) fn name(&self) -> String {
        let [parent, child] = &self.frames;
        format!("{parent} to {child}")
    }
}

impl Chain {
    /// The shortest chain from `parent` to `frame`. Where several topics have a transform, that of `topic` counts.
    pub(super) fn find(topics: &[Topic], topic: &str, parent: &str, frame: &str) -> Option<Self> {
        let links = links(topics, topic);
        // From which link each frame was reached; from the start, none.
        let mut reached: BTreeMap<&str, Option<Link>> = BTreeMap::from([(parent, None)]);
        let mut waiting = VecDeque::from([parent]);
        while let Some(here) = waiting.pop_front() {
            for link in links.values() {
                let [from, to] = link.frames.each_ref().map(String::as_str);
                let ends = [(from, to, false), (to, from, true)];
                for (from, to, is_inverse) in ends {
                    if from == here && !reached.contains_key(to) {
                        let link = Link {
                            is_inverse,
                            ..link.clone()
                        };
                        reached.insert(to, Some(link));
                        waiting.push_back(to);
                    }
                }
            }
        }
        let mut chain = Vec::new();
        let mut here = frame;
        while let Some(link) = reached.get(here)? {
            let [from, to] = &link.frames;
            here = if link.is_inverse { to } else { from };
            chain.push(link.clone());
        }
        chain.reverse();
        (!chain.is_empty()).then_some(Self { links: chain })
    }

    /// The chain that leads to a pose, if no transform of the topic does alone.
    pub(super) fn of(source: &Source, topic: &Topic, topics: &[Topic]) -> Option<Self> {
        let frames = [
            source.selector.parent.clone()?,
            source.selector.frame.clone()?,
        ];
        if !topic.has_transforms() || topic.frames.contains_key(&frames) {
            return None;
        }
        let [parent, frame] = &frames;
        Self::find(topics, &source.topic, parent, frame)
    }

    /// Its transforms in a sentence.
    pub(super) fn name(&self) -> String {
        let in_words = |link: &Link| match link.fixed {
            Some(_) => format!("{} (which never moves)", link.name()),
            None => link.name(),
        };
        let names: Vec<String> = self.links.iter().map(in_words).collect();
        names.join(" and ")
    }

    /// The place of its last frame in the first, from those of the links that move.
    pub(super) fn place(&self, mut moving: impl Iterator<Item = Rigid>) -> Rigid {
        self.links.iter().fold(Rigid::identity(), |sum, link| {
            let own = link.fixed.or_else(|| moving.next()).unwrap_or_default();
            sum * if link.is_inverse { own.inverse() } else { own }
        })
    }

    /// The topics of its transforms.
    pub(super) fn topics(&self) -> Vec<String> {
        self.links.iter().map(|link| link.topic.clone()).collect()
    }

    /// The topics of those that move.
    pub(super) fn moving_topics(&self) -> Vec<String> {
        let moving = self.links.iter().filter(|link| link.fixed.is_none());
        moving.map(|link| link.topic.clone()).collect()
    }
}

/// All transforms by their frames; where several topics have one, that of `preferred` counts. What a `tf_static` has never moves, nor does what has one value alone.
pub(super) fn links(topics: &[Topic], preferred: &str) -> BTreeMap<[String; 2], Link> {
    let mut links = BTreeMap::new();
    let (first, others): (Vec<&Topic>, _) = topics
        .iter()
        .partition(|topic| topic.channel.topic == preferred);
    for topic in first.into_iter().chain(others) {
        let name = &topic.channel.topic;
        for (frames, seen) in &topic.frames {
            let Some(place) = seen.place else { continue };
            let is_fixed = !seen.varies || name.ends_with("tf_static");
            links.entry(frames.clone()).or_insert_with(|| Link {
                frames: frames.clone(),
                topic: name.clone(),
                is_inverse: false,
                fixed: is_fixed.then_some(place),
            });
        }
    }
    links
}
