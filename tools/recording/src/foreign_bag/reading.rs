//! The second pass over a bag: messages of the mapped topics become streams.

use std::collections::{BTreeMap, BTreeSet};

use slipstream_bag::ros::time::s_from_ns;
use slipstream_bag::{Bag, ChannelInfo, Item, Loss, VisitResult};
use slipstream_bus::InputError;

use super::apart::Apart;
use super::clock::Clock;
use super::composed::Composed;
use super::source::Source;
use crate::decode::{Fields, StreamBuilder};

/// A stream being read.
pub(super) struct Reading {
    pub(super) source: Source,
    pub(super) stream: StreamBuilder,
    pub(super) way: Way,
}

/// How messages become rows.
pub(super) enum Way {
    /// Each is one, by the meaning of its type.
    Messages,
    /// Each is one: two of its numbers, or the means of several.
    Fields(Box<Fields>),
    /// A pose along several transforms.
    Composed(Box<Composed>),
    /// Wheels with a topic or a transform each.
    Apart(Box<Apart>),
}

impl Reading {
    /// Takes what a message has of the stream.
    pub(super) fn push(
        &mut self,
        channel: &ChannelInfo,
        data: &[u8],
        clock: Clock,
        log_ns: i64,
    ) -> VisitResult {
        let t_s = |stamp_ns| s_from_ns(clock.time_ns(stamp_ns, log_ns));
        let is_own = self.source.topic == channel.topic;
        match &mut self.way {
            Way::Composed(composed) => composed.push(channel, data, clock, log_ns),
            Way::Apart(apart) => apart.push(channel, data, clock, log_ns),
            Way::Messages if is_own => self.stream.push_message(channel, data, t_s),
            Way::Fields(fields) if is_own => {
                let (stamp_ns, values) = fields.read(data)?;
                self.stream.push_wheels(t_s(stamp_ns), values);
                Ok(())
            }
            Way::Messages | Way::Fields(_) => Ok(()),
        }
    }

    /// The topics that it reads, and has its times from.
    pub(super) fn topics(&self) -> Vec<String> {
        match &self.way {
            Way::Composed(composed) => composed.chain().moving_topics(),
            Way::Apart(apart) => apart.topics(),
            Way::Messages | Way::Fields(_) => vec![self.source.topic.clone()],
        }
    }
}

/// Reads all streams. Returns what could not be read, and the number of messages of topics that no stream needs.
///
/// # Errors
/// If the bag cannot be read.
pub(super) fn read_streams(
    bag: &dyn Bag,
    streams: &mut [Reading],
    clock: Clock,
) -> Result<(Loss, BTreeMap<String, u64>), InputError> {
    let mut left_out: BTreeMap<String, u64> = BTreeMap::new();
    let composed = streams.iter().filter_map(|own| match &own.way {
        Way::Composed(composed) => Some(composed),
        _ => None,
    });
    let of_chains: Vec<String> = composed.flat_map(|own| own.chain().topics()).collect();
    let needed: BTreeSet<String> = streams.iter().flat_map(Reading::topics).collect();
    let wanted = |channel: &ChannelInfo| needed.contains(&channel.topic);
    let loss = bag.scan(&wanted, &mut |item| match item {
        Item::Message {
            channel,
            log_time_ns,
            data,
            ..
        } => {
            let log_ns = i64::try_from(log_time_ns).unwrap_or(i64::MAX);
            let readings = streams.iter_mut();
            let pushed = readings.map(|reading| reading.push(channel, data, clock, log_ns));
            // All of them, even after one that fails.
            pushed.fold(Ok(()), VisitResult::and)
        }
        Item::Unwanted { channel, messages } => {
            match left_out.get_mut(&channel.topic) {
                Some(count) => *count += messages,
                None => drop(left_out.insert(channel.topic.clone(), messages)),
            }
            Ok(())
        }
        _ => Ok(()),
    })?;
    for topic in of_chains {
        // Also those of transforms that never move, which the survey has read.
        left_out.remove(&topic);
    }
    Ok((loss, left_out))
}
