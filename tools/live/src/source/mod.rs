//! Sources of a robot's rows as it drives: a file that grows, a bridge that sends, a recording that is played.

mod background;
mod bridge;
mod connection;
pub mod frame;
mod growing;
mod heard;
mod replay;
mod waiting;

pub use bridge::Bridge;
pub use growing::Growing;
pub use heard::{Heard, Source};
pub use replay::Replay;
