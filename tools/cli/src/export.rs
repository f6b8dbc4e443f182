//! `slipstream export`: writes a recording as a folder of CSV files.

use std::path::PathBuf;

use clap::Args;

use crate::exit::{Error, Exit};
use crate::models::Models;
use crate::print::{note_line, print_line};
use crate::reading::{Guesses, Reading};

/// Convert a recording to a folder of CSV files, without loss of precision
///
/// Example: slipstream export run.mcap --out run
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Recording: a folder of CSV files, or a bag (MCAP, SQLite or ROS 1; a file, or a folder as ROS 2 writes it)
    recording: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Folder to write; it must be empty or not exist
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let reading = &arguments.reading;
    let spooled = reading.spool(&arguments.recording, &Models::none(), Guesses::Brief)?;
    for (topic, messages) in &spooled.left_out {
        note_line!(
            "{topic}: left out: its {messages} messages have no equivalent in the CSV format"
        );
    }
    spooled.write_folder(&arguments.out)?;
    print_line!("{}", arguments.out.display());
    Ok(Exit::Done)
}
