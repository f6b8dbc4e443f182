//! ROS 2 messages: their fields, their definitions (`.msg`) and their CDR encoding.

pub(crate) mod cdr;
pub(crate) mod compose;
mod definitions;
pub(crate) mod messages;
pub(crate) mod position;
pub(crate) mod time;

pub(crate) use definitions::MessageType;
