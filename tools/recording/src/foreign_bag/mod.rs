//! Bags of other robots, read with a topic map or with a guess of one.

mod apart;
mod candidate;
mod chain;
mod clock;
mod composed;
mod description;
mod draft;
mod flow;
mod frames;
mod guess;
mod idle;
mod joints;
mod meaning;
mod neighbours;
mod numbers;
mod opening;
mod pairs;
mod places;
mod problems;
mod reader;
mod reading;
mod rigid;
mod rolling;
mod source;
mod survey;
mod topic_map;
mod transforms;
mod turn;
mod unused;

pub use description::WheelJoints;
pub(crate) use description::{InBag, WheelNames};
pub(crate) use draft::draft_topics;
pub(crate) use flow::{ForeignFlow, Learning};
pub(crate) use reader::{descriptions_in, read_foreign};
pub(crate) use survey::is_of_interest;
pub use topic_map::TopicMap;
