//! MCAP files laid out as ROS 2 bags: the file itself, without what the messages mean.

mod lengths;
pub(crate) mod reader;
pub(crate) mod writer;
