//! ROS messages: their fields, their definitions (`.msg`), and their encodings in ROS 2 (CDR) and ROS 1.

pub(crate) mod cdr;
pub(crate) mod compose;
mod definitions;
mod encoding;
mod layout;
#[expect(unreachable_pub, reason = "other packages will read them")]
pub(crate) mod messages;
mod numbers;
pub(crate) mod position;
mod ros1;
pub(crate) mod time;
pub mod wire;

pub(crate) use definitions::MessageType;
pub(crate) use encoding::Encoding;
pub(crate) use layout::Layout;
