//! The last messages, kept until it is known what they are.

use std::sync::Arc;

use slipstream_bag::{Bag, ChannelInfo, Item, Loss, Visit, Wanted};
use slipstream_bus::InputError;

/// So many bytes of messages are kept, at most.
const MOST_BYTES: usize = 64 << 20;
/// What a message takes beside its bytes, roughly.
const BYTES_EACH: usize = 64;

/// Messages in the order of their arrival.
#[derive(Default)]
pub(super) struct Kept {
    messages: Vec<Message>,
    bytes: usize,
}

/// A message of a channel.
pub(super) struct Message {
    pub(super) id: u32,
    pub(super) channel: Arc<ChannelInfo>,
    pub(super) log_ns: u64,
    pub(super) data: Vec<u8>,
}

impl Kept {
    /// Adds a message.
    pub(super) fn add(&mut self, message: Message) {
        self.bytes += message.data.len() + BYTES_EACH;
        self.messages.push(message);
    }

    /// Whether there is no message.
    pub(super) fn is_empty(&self) -> bool {
        self.messages.is_empty()
    }

    /// Whether no more should be kept.
    pub(super) fn is_full(&self) -> bool {
        self.bytes >= MOST_BYTES
    }

    /// The time from the first message to another one (ns), whichever comes first.
    pub(super) fn age_ns(&self, log_ns: u64) -> u64 {
        let first = self.messages.first();
        first.map_or(0, |first| first.log_ns.abs_diff(log_ns))
    }

    /// Forgets all messages but those that are sent once: what never moves, and descriptions of robots.
    pub(super) fn forget(&mut self) {
        let is_sent_once = |own: &Message| {
            let topic = &own.channel.topic;
            topic.ends_with("tf_static") || topic.ends_with("robot_description")
        };
        self.messages.retain(is_sent_once);
        self.bytes = self
            .messages
            .iter()
            .map(|own| own.data.len() + BYTES_EACH)
            .sum();
        if self.is_full() {
            *self = Self::default();
        }
    }

    /// The messages.
    pub(super) fn into_messages(self) -> Vec<Message> {
        self.messages
    }
}

impl Bag for Kept {
    fn scan(&self, wanted: &Wanted<'_>, visit: &mut Visit<'_>) -> Result<Loss, InputError> {
        let mut loss = Loss::default();
        for message in &self.messages {
            let channel = &message.channel;
            let visited = visit(match wanted(channel) {
                true => Item::Message {
                    id: message.id,
                    channel,
                    log_time_ns: message.log_ns,
                    data: &message.data,
                },
                false => Item::Unwanted {
                    channel,
                    messages: 1,
                },
            });
            match visited {
                Ok(()) => loss.messages_read += 1,
                Err(_) => loss.undecodable_messages += 1,
            }
        }
        Ok(loss)
    }
}
