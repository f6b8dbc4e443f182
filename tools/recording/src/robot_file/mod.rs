//! Descriptions of robots: `robot.toml`, URDF, parameters of controllers, constants of programs; one file or several.
//!
//! A file is recognised by its content. What it says becomes a robot model, with where each value is from,
//! what a human must fill in, and what was assumed.
//!
//! ```
//! use slipstream_recording::robot_file::{self, Kind};
//!
//! let text = "diff_drive_controller:
//!   ros__parameters:
//!     wheel_separation: 0.58
//!     wheel_radius: 0.165
//! ";
//! let described = robot_file::parse(text, "controller.yaml".as_ref())?;
//! assert_eq!(described.kind, Kind::ControllerYaml);
//! assert_eq!(described.model()?.robot.half_track_m, 0.29);
//! assert_eq!(described.taken[0].key, "wheel_radius_m");
//! assert_eq!(described.taken[0].from, "wheel_radius of diff_drive_controller");
//! # Ok::<(), slipstream_bus::InputError>(())
//! ```

mod constants;
mod content;
mod controller;
mod described;
mod drive;
mod files;
mod lengths;
mod measured_in;
mod parameter_names;
mod urdf;
mod words;
mod written;
mod xml;

use std::path::Path;

use slipstream_bag::{Result, read_text};
use slipstream_bus::{InputError, RobotModel};

pub use described::{Described, Kind, Missing, Source, Taken};

/// Reads the model of a robot from its description in one file.
///
/// # Errors
/// If the file cannot be read; else as [`parse`] and [`Described::model`].
pub fn read_model(path: &Path) -> Result<RobotModel> {
    Ok(parse(&read_text(path)?, path)?.model()?)
}

/// Parses the description of a robot. `path` is used in errors and comments, and its ending where the content
/// does not tell the kind. A text that leaves out wheel radius or track is parsed; [`Described::model`] refuses it.
///
/// # Errors
/// If the text is of no known kind or is malformed, or if a value is physically impossible.
pub fn parse(text: &str, path: &Path) -> std::result::Result<Described, InputError> {
    parse_all(&[(path, text)])
}

/// Parses the description of a robot in several files, such as a URDF and the YAML of its controller: each fills what the
/// others lack, and notes say where they contradict each other.
///
/// # Errors
/// As [`parse`]; or if two files are robot.toml, or two are URDFs.
pub fn parse_all(files: &[(&Path, &str)]) -> std::result::Result<Described, InputError> {
    files::describe(files)
}
