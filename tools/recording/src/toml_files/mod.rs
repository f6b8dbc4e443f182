//! TOML files of a recording, read strictly: `recording.toml`, `robot.toml`.

mod document;
pub(crate) mod recording_toml;
pub mod robot_toml;

pub(crate) use document::{Entry, File, read_text};
