//! Bags of other robots, read with a topic map or with a guess of one.

mod clock;
mod guess;
mod joints;
mod reader;
mod survey;
mod topic_map;

pub(crate) use reader::{draft_topics, read_foreign};
pub use topic_map::TopicMap;
