//! `slipstream import`: converts any recording to one MCAP file.

use std::path::PathBuf;

use clap::Args;

use crate::exit::{Error, Exit};
use crate::models::Models;
use crate::print::{note_line, print_line};
use crate::reading::{Guesses, Reading};

/// Convert a recording (a folder of CSV files, or a bag) to one MCAP file
///
/// Example: slipstream import FOLDER --out run.mcap
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Recording: a folder of CSV files, or a bag (MCAP, SQLite or ROS 1; a file, or a folder as ROS 2 writes it)
    recording: PathBuf,
    /// MCAP file to write
    #[arg(long, value_name = "FILE.mcap")]
    out: PathBuf,
    #[command(flatten)]
    reading: Reading,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let reading = &arguments.reading;
    let spooled = reading.spool(&arguments.recording, &Models::none(), Guesses::Brief)?;
    for (topic, messages) in &spooled.left_out {
        note_line!("{topic}: left out: its {messages} messages belong to no stream");
    }
    spooled.write_mcap(&arguments.out)?;
    print_line!("{}", arguments.out.display());
    Ok(Exit::Done)
}
