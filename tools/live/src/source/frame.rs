//! What a server of Foxglove's WebSocket protocol sends, frame by frame.
//!
//! Subprotocols `foxglove.sdk.v1` and `foxglove.websocket.v1`; frames that say nothing about topics and messages are
//! [`Frame::Other`].

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::Deserialize;

/// What a frame says.
#[derive(Debug, PartialEq, Eq)]
pub enum Frame<'a> {
    /// Who the server is.
    Server {
        /// Its name.
        name: String,
    },
    /// Topics that can be subscribed to.
    Advertised(Vec<Channel<'a>>),
    /// Topics, by their ids, that are no more.
    Withdrawn(Vec<u64>),
    /// Something for a person to know.
    Status(String),
    /// A message.
    Message {
        /// The number that the subscription gave.
        subscription: u32,
        /// Time of reception (ns).
        log_ns: u64,
        /// The message as its topic encodes it.
        data: &'a [u8],
    },
    /// Something else.
    Other,
}

/// A topic.
#[derive(Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Channel<'a> {
    /// Its number on this connection.
    pub id: u64,
    /// Its name.
    #[serde(borrow)]
    pub topic: Cow<'a, str>,
    /// Encoding of its messages, such as `cdr`.
    #[serde(borrow, default)]
    pub encoding: Cow<'a, str>,
    /// Name of their type; empty if they have none.
    #[serde(borrow, default)]
    pub schema_name: Cow<'a, str>,
    /// Encoding of the definition; not every server says it.
    #[serde(borrow, default)]
    pub schema_encoding: Option<Cow<'a, str>>,
    /// The definition.
    #[serde(borrow, default)]
    pub schema: Cow<'a, str>,
    /// Names and values.
    #[serde(default)]
    pub metadata: BTreeMap<String, String>,
}

/// Why a frame cannot be understood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Garbled {
    /// A text that is no JSON object with `op`.
    Text,
    /// An operation without what belongs to it.
    Operation,
    /// Bytes that end too early.
    Short,
}

impl Garbled {
    /// The words for it, which continue "a frame".
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Text => "that is no JSON object with `op`",
            Self::Operation => "whose operation lacks what belongs to it",
            Self::Short => "that ends too early",
        }
    }
}

#[derive(Deserialize)]
struct Operation<'a> {
    #[serde(borrow)]
    op: Cow<'a, str>,
}

#[derive(Deserialize)]
struct ServerInfo {
    #[serde(default)]
    name: String,
}

#[derive(Deserialize)]
struct Advertise<'a> {
    #[serde(borrow)]
    channels: Vec<Channel<'a>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Unadvertise {
    channel_ids: Vec<u64>,
}

#[derive(Deserialize)]
struct Status {
    #[serde(default)]
    message: String,
}

/// Reads a text frame.
///
/// # Errors
/// If it is none of the protocol.
pub fn text(text: &str) -> Result<Frame<'_>, Garbled> {
    let operation: Operation<'_> = serde_json::from_str(text).map_err(|_| Garbled::Text)?;
    match &*operation.op {
        "serverInfo" => {
            let ServerInfo { name } = content(text)?;
            Ok(Frame::Server { name })
        }
        "advertise" => {
            let Advertise { channels } = content(text)?;
            Ok(Frame::Advertised(channels))
        }
        "unadvertise" => {
            let Unadvertise { channel_ids } = content(text)?;
            Ok(Frame::Withdrawn(channel_ids))
        }
        "status" => {
            let Status { message } = content(text)?;
            Ok(Frame::Status(message))
        }
        _ => Ok(Frame::Other),
    }
}

fn content<'a, T: Deserialize<'a>>(text: &'a str) -> Result<T, Garbled> {
    serde_json::from_str(text).map_err(|_| Garbled::Operation)
}

/// Reads a binary frame.
///
/// # Errors
/// If it is none of the protocol.
pub fn binary(bytes: &[u8]) -> Result<Frame<'_>, Garbled> {
    let (opcode, rest) = bytes.split_first().ok_or(Garbled::Short)?;
    if *opcode != 1 {
        return Ok(Frame::Other);
    }
    let (subscription, rest) = rest.split_first_chunk().ok_or(Garbled::Short)?;
    let (log_ns, data) = rest.split_first_chunk().ok_or(Garbled::Short)?;
    Ok(Frame::Message {
        subscription: u32::from_le_bytes(*subscription),
        log_ns: u64::from_le_bytes(*log_ns),
        data,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_is_read_as_servers_announce_it() {
        let said = r#"{"op":"advertise","channels":[{"id":3,"topic":"/odom","encoding":"cdr",
            "schemaName":"nav_msgs/msg/Odometry","schema":"a\nb","more":1}]}"#;
        let Ok(Frame::Advertised(channels)) = text(said) else {
            panic!("not read");
        };
        assert_eq!(channels[0].topic, "/odom");
        assert_eq!(channels[0].schema, "a\nb");
        assert_eq!(channels[0].schema_encoding, None);
        assert_eq!(text(r#"{"op":"time"}"#), Ok(Frame::Other));
        let server = text(r#"{"op":"serverInfo","name":"r","capabilities":[]}"#);
        assert!(matches!(server, Ok(Frame::Server { name }) if name == "r"));
        let gone = text(r#"{"op":"unadvertise","channelIds":[7]}"#);
        assert_eq!(gone, Ok(Frame::Withdrawn(vec![7])));
    }

    #[test]
    fn what_is_garbled_is_said_to_be() {
        assert_eq!(text("hello"), Err(Garbled::Text));
        assert_eq!(text(r#"{"channels":[]}"#), Err(Garbled::Text));
        assert_eq!(text(r#"{"op":"advertise"}"#), Err(Garbled::Operation));
        let id = r#"{"op":"advertise","channels":[{"id":-1,"topic":"/a"}]}"#;
        assert_eq!(text(id), Err(Garbled::Operation));
        assert_eq!(binary(&[]), Err(Garbled::Short));
        assert_eq!(binary(&[1; 12]), Err(Garbled::Short));
        assert_eq!(binary(&[2, 0]), Ok(Frame::Other));
        let bytes = [&[1, 5, 0, 0, 0][..], &9_u64.to_le_bytes(), b"ab"].concat();
        let message = Frame::Message {
            subscription: 5,
            log_ns: 9,
            data: b"ab",
        };
        assert_eq!(binary(&bytes), Ok(message));
    }

    #[test]
    fn no_bytes_make_it_panic() {
        // A small generator of numbers: the same ones in every run.
        let mut state = 1_u64;
        let mut random = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as usize
        };
        let seed = r#"{"op":"advertise","channels":[{"id":3,"topic":"/o","metadata":{"a":"b"}}]}"#;
        for _ in 0..20_000 {
            let mut bytes = seed.as_bytes().to_vec();
            for _ in 0..random() % 4 {
                let at = random() % bytes.len();
                bytes[at] = random() as u8;
            }
            bytes.truncate(random() % (bytes.len() + 1));
            let _ = binary(&bytes);
            let _ = text(&String::from_utf8_lossy(&bytes));
        }
    }
}
