//! Descriptions of robots that a bag carries.

use super::survey::Topic;

/// A description in a bag: its topic, and its text (a URDF).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct InBag {
    pub(crate) topic: String,
    pub(crate) text: String,
}

/// Names of the joints of a robot's driven wheels, right and left, as a description has them.
pub(crate) type WheelJoints = [Vec<String>; 2];

/// Whoever knows the wheels of descriptions.
pub(crate) type WheelsOf<'a> = dyn Fn(&InBag) -> Option<WheelJoints> + 'a;

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
