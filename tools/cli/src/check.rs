//! `slipstream check`: what a recording can be used for.

use std::path::PathBuf;

use clap::Args;
use slipstream_recording::{TopicMap, robot_toml};

use crate::exit::{Error, Exit};
use crate::say::{self, complain};

/// Look a recording over before any diagnosis: rates, gaps, units, swapped wheels, clocks.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Folder with recording.toml, or an MCAP file.
    recording: PathBuf,
    /// The robot's model; without it the one that came with the recording.
    #[arg(long, value_name = "FILE.toml")]
    robot: Option<PathBuf>,
    /// Which topic of a bag is which stream; guessed without it.
    #[arg(long, value_name = "FILE.toml")]
    topics: Option<PathBuf>,
    /// Write the report as JSON, too.
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
    let import = slipstream_recording::read_mapped(&arguments.recording, topics.as_ref())?;
    let model = arguments
        .robot
        .as_deref()
        .map(robot_toml::read)
        .transpose()?;
    for warning in &import.warnings {
        complain!("{warning}");
    }
    let report = slipstream_recording::check(&import.recording, model.as_ref());
    say::out(format_args!("{report}"));
    if let Some(path) = &arguments.json {
        crate::file::write_json(path, &report)?;
    }
    Ok(Exit::Done)
}
