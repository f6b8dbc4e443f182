//! `slipstream check`: data quality of a recording, and what can be concluded from it.

use std::path::PathBuf;

use clap::Args;
use slipstream_recording::TopicMap;

use crate::exit::{Error, Exit};
use crate::models::read_model;
use crate::print::{self, eprint_line};

/// Check a recording: rates, gaps, units, swapped or reversed wheels, clocks
///
/// Example: slipstream check RECORDING --robot robot.toml
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Folder with recording.toml, or an MCAP file
    recording: PathBuf,
    /// Robot model: robot.toml, URDF or diff_drive_controller YAML [default: the one in the recording]
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Map from the topics of a bag to streams [default: guessed from types and names]
    #[arg(long, value_name = "FILE.toml")]
    topics: Option<PathBuf>,
    /// Write the report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let topics = arguments
        .topics
        .as_deref()
        .map(TopicMap::read)
        .transpose()?;
    let spooled = slipstream_recording::read_spooled(&arguments.recording, topics.as_ref())?;
    let model = arguments.robot.as_deref().map(read_model).transpose()?;
    for warning in &spooled.warnings {
        eprint_line!("{warning}");
    }
    let report = spooled.check(model.as_ref())?;
    print::out(format_args!("{report}"));
    if let Some(path) = &arguments.json {
        crate::output_file::write_json(path, &report)?;
    }
    Ok(Exit::Done)
}
