//! The two encodings of ROS messages.

use serde::Deserialize;

use super::messages::{TfMessage, TransformStamped};
use super::{cdr, ros1};

/// How the messages of a topic are encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// CDR, of ROS 2.
    Cdr,
    /// That of ROS 1, whose headers begin with a sequence number; WPILib's packed values, which have no header, are the
    /// same.
    Ros1,
}

/// A part of a ROS 1 message that begins with a header.
#[derive(Deserialize)]
struct Sequenced<T> {
    #[serde(rename = "seq")]
    _seq: u32,
    part: T,
}

impl Encoding {
    /// The encoding that a bag calls so; `None` for others.
    pub fn of(name: &str) -> Option<Self> {
        match name {
            "cdr" => Some(Self::Cdr),
            "ros1" | "wpilog" => Some(Self::Ros1),
            _ => None,
        }
    }

    /// Decodes a message that does not begin with a header.
    ///
    /// # Errors
    /// If the bytes are not a message of this type.
    pub fn decode<'a, T: Deserialize<'a>>(self, bytes: &'a [u8]) -> Result<T, String> {
        match self {
            Self::Cdr => cdr::decode(bytes),
            Self::Ros1 => ros1::decode(bytes),
        }
    }

    /// Decodes a message that begins with a header, or only its header.
    ///
    /// # Errors
    /// If the bytes are not a message of this type.
    pub fn decode_stamped<'a, T: Deserialize<'a>>(self, bytes: &'a [u8]) -> Result<T, String> {
        match self {
            Self::Cdr => cdr::decode(bytes),
            Self::Ros1 => ros1::decode(bytes).map(|message: Sequenced<T>| message.part),
        }
    }

    /// Decodes a list of transforms.
    ///
    /// # Errors
    /// If the bytes are not such a message.
    pub fn decode_transforms(self, bytes: &[u8]) -> Result<Vec<TransformStamped<String>>, String> {
        match self {
            Self::Cdr => {
                let message: TfMessage<Vec<TransformStamped<String>>> = cdr::decode(bytes)?;
                Ok(message.transforms)
            }
            Self::Ros1 => {
                let parts: Vec<Sequenced<_>> = ros1::decode(bytes)?;
                Ok(parts.into_iter().map(|part| part.part).collect())
            }
        }
    }
}
