//! ROS 2 bags of other robots, read with a topic map or with a guess of one.

mod guess;
mod reader;
mod survey;
mod topic_map;

pub(crate) use reader::read_foreign;
pub(crate) use survey::Open;
pub use topic_map::TopicMap;
