//! Streams assembled from ROS messages that arrive one by one.

mod fields;
mod links;
mod sample;
mod speeds;
mod streams;

pub(crate) use fields::{Fields, Stamp, layout_of};
pub(crate) use links::{LinksBuilder, RoundTripsBuilder};
pub(crate) use sample::{JointState, MessageSelector, NoSample, Sample};
pub(crate) use speeds::PoseSpeeds;
pub use speeds::wrapped;
pub(crate) use streams::StreamBuilder;
