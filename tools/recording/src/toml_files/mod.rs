//! TOML files: a strict reader, the description `recording.toml` and the robot model `robot.toml`.

mod document;
pub mod recording_toml;
pub mod robot_toml;

pub(crate) use document::{Entry, Section, TomlFile, counts_value, quoted};
