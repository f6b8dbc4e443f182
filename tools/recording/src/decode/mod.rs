//! Streams assembled from ROS 2 messages that arrive one by one.

mod links;
mod sample;
mod streams;

pub(crate) use links::{LinksBuilder, RoundTripsBuilder};
pub(crate) use sample::{MessageSelector, Sample};
pub(crate) use streams::StreamBuilder;
