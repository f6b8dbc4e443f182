//! Recordings: one in-memory form, in and out as MCAP and as CSV folders; the robot's model.

mod error;
pub mod recording;
pub mod robot_toml;
mod toml_file;

pub use error::{Error, Result, Unusable};
pub use recording::Recording;
