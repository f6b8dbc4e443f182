//! Descriptions of robots: `robot.toml`, URDF, or the parameters of ros2_control's diff_drive_controller.
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

mod content;
mod controller_yaml;
mod described;
mod urdf;
mod written;
mod xml;

use std::path::Path;

use slipstream_bus::{InputError, RobotModel};

use crate::error::Result;
use crate::toml_files::robot_toml;

pub use described::{Described, Kind, Missing, Taken};

/// Reads the description of a robot.
///
/// # Errors
/// If the file cannot be read, is of no known kind or is malformed, or if a value is physically impossible. A
/// file that leaves out wheel radius or track is read; [`Described::model`] refuses it.
pub fn read(path: &Path) -> Result<Described> {
    Ok(parse(&content::read_text(path)?, path)?)
}

/// Reads the model of a robot from its description.
///
/// # Errors
/// As [`read`] and [`Described::model`].
pub fn read_model(path: &Path) -> Result<RobotModel> {
    Ok(read(path)?.model()?)
}

/// Parses the description of a robot. `path` is used in errors and comments, and its ending where the content
/// does not tell the kind.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> std::result::Result<Described, InputError> {
    match content::kind(text, path) {
        Kind::Urdf => urdf::describe(text, path),
        Kind::ControllerYaml => controller_yaml::describe(text, path),
        Kind::RobotToml => Ok(Described::of_model(robot_toml::parse(text, path)?, path)),
    }
}
