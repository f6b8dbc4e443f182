//! MCAP files in the layout of ROS 2 bags: the container, without the meaning of its messages.

mod chunk;
mod file;
mod lengths;
mod loss;
mod reader;
mod writer;

pub(crate) use file::open_file;
pub use loss::Loss;
pub(crate) use reader::{ChannelInfo, Item, Undecodable, VisitResult, read_bag};
pub(crate) use writer::{BagWriter, Channel, announce};
