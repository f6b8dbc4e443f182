//! `slipstream export`: a recording into a folder of CSV files.

use std::path::PathBuf;

use clap::Args;

use crate::exit::{Error, Exit};
use crate::say::{complain, say};

/// Turn a recording into a folder of CSV files, to the digit.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The MCAP file.
    recording: PathBuf,
    /// The folder to write; it must not exist or be empty.
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let import = slipstream_recording::read(&arguments.recording)?;
    for warning in &import.warnings {
        complain!("{warning}");
    }
    for (topic, messages) in &import.left_out {
        complain!("{topic}: {messages} messages have no place in the CSV format; left out");
    }
    slipstream_recording::write_folder(&import.recording, &arguments.out)?;
    say!("{}", arguments.out.display());
    Ok(Exit::Done)
}
