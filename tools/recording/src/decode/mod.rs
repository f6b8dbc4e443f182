//! Streams out of ROS 2 messages.

mod links;
mod number;
mod sample;
mod streams;

pub(crate) use links::{LinksBuilder, RoundTripsBuilder};
pub(crate) use sample::{Pick, Sample};
pub(crate) use streams::StreamBuilder;
