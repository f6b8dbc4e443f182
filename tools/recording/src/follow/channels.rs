//! The topics whose messages are needed, by a number of our own that outlasts a connection and a file.

use std::collections::BTreeMap;
use std::sync::Arc;

use slipstream_bag::ChannelInfo;

/// So many topics are told apart. A program may announce any number of them.
const MOST: usize = 4096;

/// Topics by their numbers.
#[derive(Default)]
pub(super) struct Channels {
    all: Vec<Arc<ChannelInfo>>,
    /// Numbers by name, type and encoding.
    numbers: BTreeMap<[String; 3], u32>,
}

impl Channels {
    /// The number of a topic, and whether it is new. `None` if there are too many.
    pub(super) fn number(&mut self, channel: &ChannelInfo) -> Option<(u32, bool)> {
        let key = [&channel.topic, &channel.schema, &channel.encoding].map(String::clone);
        if let Some(known) = self.numbers.get(&key) {
            return Some((*known, false));
        }
        let number = u32::try_from(self.all.len()).ok()?;
        if self.all.len() >= MOST {
            return None;
        }
        self.all.push(Arc::new(channel.clone()));
        self.numbers.insert(key, number);
        Some((number, true))
    }

    /// The topic with a number.
    pub(super) fn get(&self, number: u32) -> Option<&Arc<ChannelInfo>> {
        self.all.get(number as usize)
    }

    /// All topics with their numbers.
    pub(super) fn all(&self) -> impl Iterator<Item = (u32, &Arc<ChannelInfo>)> {
        (0..).zip(&self.all)
    }
}
