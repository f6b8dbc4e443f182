//! What a bag contains, whatever its container: topics, messages, attached files.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::listener::Announced;

/// A channel of a file: a topic with its type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ChannelInfo {
    /// Name of the topic.
    pub(crate) topic: String,
    /// Name of the message type, such as `sensor_msgs/msg/Imu`; empty if there is none.
    pub(crate) schema: String,
    /// Encoding of the messages, such as `cdr`.
    pub(crate) encoding: String,
    /// Encoding and bytes of the definition of the type.
    pub(crate) definition: Arc<(String, Vec<u8>)>,
    /// Names and values.
    pub(crate) metadata: BTreeMap<String, String>,
}

/// The type of a channel: its name, and its definition with its encoding.
pub(super) type Schema = (String, Arc<(String, Vec<u8>)>);

impl ChannelInfo {
    /// A channel of an MCAP file.
    pub(super) fn new(channel: mcap::records::Channel, (schema, definition): Schema) -> Self {
        let schema = match channel.message_encoding.as_str() {
            "ros1" => ros2_name(&schema),
            _ => schema,
        };
        Self {
            topic: channel.topic,
            schema,
            definition,
            encoding: channel.message_encoding,
            metadata: channel.metadata,
        }
    }
}

impl From<&Announced<'_>> for ChannelInfo {
    fn from(own: &Announced<'_>) -> Self {
        let definition = Arc::new((own.schema_encoding.to_owned(), own.schema.to_owned()));
        let channel = mcap::records::Channel {
            id: 0,
            schema_id: 0,
            topic: own.topic.to_owned(),
            message_encoding: own.encoding.to_owned(),
            metadata: own.metadata.clone(),
        };
        Self::new(channel, (own.schema_name.to_owned(), definition))
    }
}

/// The name of a ROS 1 message type as ROS 2 writes it: `sensor_msgs/msg/Imu` for `sensor_msgs/Imu`.
pub(super) fn ros2_name(name: &str) -> String {
    match name.split_once('/') {
        Some((package, message)) if !message.contains('/') => format!("{package}/msg/{message}"),
        _ => name.to_owned(),
    }
}

/// An item of a file, in file order.
pub(crate) enum Item<'a> {
    /// A channel, before its messages.
    Channel {
        id: u32,
        channel: &'a Arc<ChannelInfo>,
    },
    /// A message of the channel `id` (ids may be sparse).
    Message {
        id: u32,
        channel: &'a Arc<ChannelInfo>,
        log_time_ns: u64,
        data: &'a [u8],
    },
    /// Messages of a channel that is not wanted.
    Unwanted {
        channel: &'a Arc<ChannelInfo>,
        messages: u64,
    },
    /// An attached file.
    Attachment { name: &'a str, data: &'a [u8] },
    /// A record of names and values; only its own name is read.
    Metadata { name: &'a str },
}

/// Whether the visitor could decode an item.
pub(crate) type VisitResult = Result<(), Undecodable>;

/// The visitor could not decode the item.
#[derive(Debug)]
pub(crate) struct Undecodable;

/// Whoever wants the items of a bag.
pub(crate) type Visit<'a> = dyn FnMut(Item<'_>) -> VisitResult + 'a;

/// Whether the messages of a topic are wanted.
pub(crate) type Wanted<'a> = dyn Fn(&ChannelInfo) -> bool + 'a;
