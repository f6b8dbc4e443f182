//! `slipstream check`: data quality of a recording, and what can be concluded from it.

use std::path::PathBuf;

use clap::Args;

use crate::exit::{Error, Exit};
use crate::models::read_model;
use crate::print::{self, print_line};
use crate::reading::Reading;

/// Check a recording: rates, gaps, units, swapped or reversed wheels, clocks
///
/// Example: slipstream check RECORDING --robot robot.toml
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Recording: a folder of CSV files, or a bag (MCAP, SQLite or ROS 1; a file, or a folder as ROS 2 writes it)
    recording: PathBuf,
    /// Robot model: robot.toml, URDF or diff_drive_controller YAML [default: the one in the recording]
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Write the guessed map of a bag's topics, to be corrected and given with --topics; checks nothing
    #[arg(long, value_name = "FILE.toml")]
    write_topics: Option<PathBuf>,
    /// Write the guess of a map of text files, to be corrected and given with --columns; checks nothing
    #[arg(long, value_name = "FILE.toml", conflicts_with = "write_topics")]
    write_columns: Option<PathBuf>,
    /// Write the report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let to_write = arguments.write_topics.as_ref();
    if let Some(file) = to_write.or(arguments.write_columns.as_ref()) {
        let map = slipstream_recording::draft_map(&arguments.recording)?;
        crate::output_file::write(file, &map)?;
        print_line!("{}", file.display());
        return Ok(Exit::Done);
    }
    let spooled = arguments
        .reading
        .spool_for(&arguments.recording, arguments.robot.is_some())?;
    let model = arguments.robot.as_deref().map(read_model).transpose()?;
    let report = spooled.check(model.as_ref())?;
    print::out(format_args!("{report}"));
    if let Some(path) = &arguments.json {
        crate::output_file::write_json(path, &report)?;
    }
    Ok(Exit::Done)
}
