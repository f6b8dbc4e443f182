//! Bags of other robots, read with a topic map or with a guess of one.

mod candidate;
mod chain;
mod clock;
mod composed;
mod description;
mod guess;
mod joints;
mod reader;
mod reading;
mod rigid;
mod survey;
mod topic_map;
mod transforms;

pub(crate) use description::InBag;
pub(crate) use reader::{descriptions_in, draft_topics, read_foreign};
pub use topic_map::TopicMap;
