//! Records a run as it happens.

mod about;
mod writer;

pub use crate::ros2::position::{Fate, PositionRecord};
pub use about::{About, Attachment, WheelContact};
pub use writer::RunWriter;
