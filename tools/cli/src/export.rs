//! `slipstream export`: writes a recording as a folder of CSV files.

use std::path::PathBuf;

use clap::Args;

use crate::exit::{Error, Exit};
use crate::print::{eprint_line, print_line};

/// Convert a recording to a folder of CSV files, without loss of precision
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
        eprint_line!("{warning}");
    }
    for (topic, messages) in &import.left_out {
        eprint_line!(
            "{topic}: left out: its {messages} messages have no equivalent in the CSV format"
        );
    }
    slipstream_recording::write_folder(&import.recording, &arguments.out)?;
    print_line!("{}", arguments.out.display());
    Ok(Exit::Done)
}
