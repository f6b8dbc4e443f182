//! The channels that a file announced, by their number.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::item::{ChannelInfo, Item, Undecodable, Visit, VisitResult, Wanted};

/// Announced channels, and who is told of them and of their messages.
pub(super) struct Channels<'a> {
    wanted: &'a Wanted<'a>,
    visit: &'a mut Visit<'a>,
    /// Each with whether its messages are wanted.
    known: BTreeMap<u32, (Arc<ChannelInfo>, bool)>,
}

impl<'a> Channels<'a> {
    /// None yet.
    pub(super) fn new(wanted: &'a Wanted<'a>, visit: &'a mut Visit<'a>) -> Self {
        Self {
            wanted,
            visit,
            known: BTreeMap::new(),
        }
    }

    /// Whether there is a channel of this number.
    pub(super) fn has(&self, id: u32) -> bool {
        self.known.contains_key(&id)
    }

    /// Adds a channel, in place of one with the same number.
    pub(super) fn add(&mut self, id: u32, channel: ChannelInfo) -> VisitResult {
        let channel = Arc::new(channel);
        let visited = (self.visit)(Item::Channel {
            id,
            channel: &channel,
        });
        let is_wanted = (self.wanted)(&channel);
        self.known.insert(id, (channel, is_wanted));
        visited
    }

    /// Removes a channel. `None` if there is none of this number.
    pub(super) fn remove(&mut self, id: u32) -> Option<()> {
        self.known.remove(&id).map(|_| ())
    }

    /// Tells of a message. Its time (ns) is asked for only if it is wanted.
    pub(super) fn message(
        &mut self,
        id: u32,
        log_time_ns: impl FnOnce() -> Option<u64>,
        data: &[u8],
    ) -> VisitResult {
        let (channel, is_wanted) = self.known.get(&id).ok_or(Undecodable)?;
        (self.visit)(match is_wanted {
            true => Item::Message {
                id,
                channel,
                log_time_ns: log_time_ns().ok_or(Undecodable)?,
                data,
            },
            false => Item::Unwanted {
                channel,
                messages: 1,
            },
        })
    }
}
