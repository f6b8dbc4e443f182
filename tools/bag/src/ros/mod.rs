//! ROS messages: their fields, their definitions (`.msg`), and their encodings in ROS 2 (CDR) and ROS 1.

pub mod cdr;
pub mod compose;
mod definitions;
mod encoding;
mod layout;
#[expect(missing_docs, reason = "names and fields are those of the definitions")]
pub mod messages;
mod numbers;
mod ros1;
pub mod time;
pub mod wire;

pub use definitions::MessageType;
pub use encoding::Encoding;
pub use layout::Layout;
pub use numbers::{Number, Take};
