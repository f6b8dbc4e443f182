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
    let spooled = slipstream_recording::read_spooled(&arguments.recording, None)?;
    for warning in &spooled.warnings {
        eprint_line!("{warning}");
    }
    for (topic, messages) in &spooled.left_out {
        eprint_line!(
            "{topic}: left out: its {messages} messages have no equivalent in the CSV format"
        );
    }
    spooled.write_folder(&arguments.out)?;
    print_line!("{}", arguments.out.display());
    Ok(Exit::Done)
}
