//! What a bag contains, whatever its container: topics, messages, attached files.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::listener::Announced;

/// A channel of a file: a topic with its type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelInfo {
    /// Name of the topic.
    pub topic: String,
    /// Name of the message type, such as `sensor_msgs/msg/Imu`; empty if there is none.
    pub schema: String,
    /// Encoding of the messages, such as `cdr`.
    pub encoding: String,
    /// Encoding and bytes of the definition of the type.
    pub definition: Arc<(String, Vec<u8>)>,
    /// Names and values.
    pub metadata: BTreeMap<String, String>,
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
pub enum Item<'a> {
    /// A channel, before its messages.
    Channel {
        /// Its number.
        id: u32,
        /// What it is.
        channel: &'a Arc<ChannelInfo>,
    },
    /// A message of the channel `id` (ids may be sparse).
    Message {
        /// Number of its channel.
        id: u32,
        /// Its channel.
        channel: &'a Arc<ChannelInfo>,
        /// When it was recorded (ns).
        log_time_ns: u64,
        /// The encoded message.
        data: &'a [u8],
    },
    /// Messages of a channel that is not wanted.
    Unwanted {
        /// Their channel.
        channel: &'a Arc<ChannelInfo>,
        /// How many there are.
        messages: u64,
    },
    /// An attached file.
    Attachment {
        /// Its name.
        name: &'a str,
        /// Its content.
        data: &'a [u8],
    },
    /// A record of names and values; only its own name is read.
    Metadata {
        /// Its name.
        name: &'a str,
    },
}

/// Whether the visitor could decode an item.
pub type VisitResult = Result<(), Undecodable>;

/// The visitor could not decode the item.
#[derive(Debug)]
pub struct Undecodable;

/// Whoever wants the items of a bag.
pub type Visit<'a> = dyn FnMut(Item<'_>) -> VisitResult + 'a;

/// Whether the messages of a topic are wanted.
pub type Wanted<'a> = dyn Fn(&ChannelInfo) -> bool + 'a;
