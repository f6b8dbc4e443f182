//! Fuzz targets: what must hold of every reader, whatever its input is.
//!
//! A target takes any bytes and panics if a property does not hold. The properties are: nothing
//! panics, an error is one line, and what was accepted can be written and read again identically.
//! The programs in `fuzz_targets` run the targets under libFuzzer (`just fuzz`); the test `short`
//! runs them over the kept seeds and over seeded mutations of them, on stable Rust.

#![expect(
    clippy::expect_used,
    clippy::panic,
    reason = "a target reports a property that does not hold by a panic"
)]

mod bridge;
mod messages;
pub mod mutate;
mod one_line;
mod postcard_data;
mod recordings;
mod robot_files;
mod runs;
mod scratch;
mod toml_texts;

pub use recordings::{FILES, MAP, SEPARATOR, SOURCES};

/// A reader with the properties that are asserted of it.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name, which is that of its program and of its folder of seeds.
    pub name: &'static str,
    /// Reads the input and asserts the properties.
    pub run: fn(&[u8]),
}

/// All targets.
pub const TARGETS: [Target; 28] = [
    target("mcap", recordings::mcap),
    target("bag", recordings::bag),
    target("ros1_bag", recordings::bag),
    target("sqlite_bag", recordings::bag),
    target("message", messages::message),
    target("wpilog", recordings::bag),
    target("csv_folder", recordings::csv_folder),
    target("foreign_csv", recordings::foreign_csv),
    target("text_file", recordings::any_file),
    target("sysid_json", recordings::any_file),
    target("recording_toml", toml_texts::recording_toml),
    target("robot_toml", toml_texts::robot_toml),
    target("urdf", robot_files::urdf),
    target("controller_yaml", robot_files::controller_yaml),
    target("constants", robot_files::constants),
    target("urdf_and_yaml", robot_files::urdf_and_yaml),
    target("robot_run", runs::robot_run),
    target("topic_map", toml_texts::topic_map),
    target("experiment_file", toml_texts::experiment_file),
    target("set_arguments", toml_texts::set_arguments),
    target("round_trips", toml_texts::round_trips),
    target("experiment", postcard_data::experiment),
    target("record_chunk", postcard_data::record_chunk),
    target("reports", postcard_data::reports),
    target("host_frame", postcard_data::host_frame),
    target("bridge_frame", bridge::frame),
    target("trace_chunk", postcard_data::trace_chunk),
    target("trace_buffer", postcard_data::trace_buffer),
];

const fn target(name: &'static str, run: fn(&[u8])) -> Target {
    Target { name, run }
}

/// Runs the target of this name.
///
/// # Panics
/// If there is no such target, or a property does not hold.
pub fn run(name: &str, input: &[u8]) {
    let target = TARGETS.iter().find(|target| target.name == name);
    let target = target.unwrap_or_else(|| panic!("there is no target {name}"));
    (target.run)(input);
}
