//! MCAP files laid out as ROS 2 bags: the file itself, without what the messages mean.

mod chunk;
mod file;
mod lengths;
mod loss;
mod reader;
mod writer;

pub(crate) use file::open;
pub use loss::Loss;
pub(crate) use reader::{ChannelInfo, Item, Undecodable, Visited, read_bag};
pub(crate) use writer::{BagWriter, Channel};
