//! `slipstream export`: writes a recording as a folder of CSV files.

use std::path::PathBuf;

use clap::Args;

use crate::exit::{Error, Exit};
use crate::print::{complain, say};

/// Convert a recording to a folder of CSV files, without loss of digits
///
/// Example: slipstream export run.mcap --out run
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// MCAP file
    recording: PathBuf,
    /// Folder to write; it must be empty or not exist
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
        complain!(
            "{topic}: left out: its {messages} messages have no equivalent in the CSV format"
        );
    }
    slipstream_recording::write_folder(&import.recording, &arguments.out)?;
    say!("{}", arguments.out.display());
    Ok(Exit::Done)
}
