//! ROS 2 bags of other robots.

mod guess;
mod reader;
mod survey;
mod topic_map;

pub(crate) use reader::read_foreign;
pub use topic_map::TopicMap;
