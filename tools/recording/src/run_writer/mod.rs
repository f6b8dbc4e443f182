//! Recorder of a run: writes a run to an MCAP file while it happens.

mod channels;
mod contact;
mod header;
mod writer;

pub use crate::ros2::position::{Fate, PositionRecord};
pub use contact::WheelContact;
pub use header::{Attachment, RunHeader};
pub use writer::RunWriter;
