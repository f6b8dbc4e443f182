//! Descriptions of robots that a bag carries, and the wheels that descriptions name.

use super::survey::Topic;

/// A description in a bag: its topic, and its text (a URDF).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct InBag {
    pub(crate) topic: String,
    pub(crate) text: String,
}

/// Names of the joints of a robot's driven wheels, right and left, as a description has them.
pub type WheelJoints = [Vec<String>; 2];

/// Whoever knows the wheels of descriptions.
pub(crate) struct WheelNames<'a> {
    /// Those that the user gave, which count more.
    pub(crate) given: &'a [WheelJoints],
    /// Reads one of the bag.
    pub(crate) of: &'a dyn Fn(&InBag) -> Option<WheelJoints>,
}

impl WheelNames<'_> {
    /// All wheels, those that the user gave first.
    pub(super) fn all(&self, described: &[InBag]) -> Vec<WheelJoints> {
        let in_bag = described.iter().filter_map(self.of);
        self.given.iter().cloned().chain(in_bag).collect()
    }
}

/// The descriptions, without those that another topic repeats.
pub(super) fn descriptions(topics: &[Topic]) -> Vec<InBag> {
    let mut all: Vec<InBag> = Vec::new();
    for topic in topics {
        if let Some(text) = &topic.description
            && all.iter().all(|own| own.text != *text)
        {
            all.push(InBag {
                topic: topic.channel.topic.clone(),
                text: text.clone(),
            });
        }
    }
    all
}
