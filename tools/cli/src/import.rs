//! `slipstream import`: converts any recording to one MCAP file.

use std::path::PathBuf;

use clap::Args;
use slipstream_recording::TopicMap;

use crate::exit::{Error, Exit};
use crate::print::{eprint_line, print_line};

/// Convert a recording (a folder of CSV files, or a ROS 2 bag in MCAP) to one MCAP file
///
/// Example: slipstream import FOLDER --out run.mcap
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Folder with recording.toml, or an MCAP file
    recording: PathBuf,
    /// MCAP file to write
    #[arg(long, value_name = "FILE.mcap")]
    out: PathBuf,
    /// Map from the topics of a bag to streams [default: guessed from types and names]
    #[arg(long, value_name = "FILE.toml")]
    topics: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let topics = arguments
        .topics
        .as_deref()
        .map(TopicMap::read)
        .transpose()?;
    let spooled = slipstream_recording::read_spooled(&arguments.recording, topics.as_ref())?;
    for warning in &spooled.warnings {
        eprint_line!("{warning}");
    }
    for (topic, messages) in &spooled.left_out {
        eprint_line!("{topic}: left out: its {messages} messages belong to no stream");
    }
    spooled.write_mcap(&arguments.out)?;
    print_line!("{}", arguments.out.display());
    Ok(Exit::Done)
}
