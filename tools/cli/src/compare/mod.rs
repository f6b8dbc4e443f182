//! `slipstream compare`: a recording beside its simulation, or two recordings of one experiment beside each other.

mod recorded;
mod simulated;
mod table;

use std::path::PathBuf;

use clap::Args;

use crate::exit::{Error, Exit};
use crate::reading::Reading;

/// Put a recording beside its simulation, or two recordings of one experiment beside each other
///
/// With one recording, its commands are simulated, and the result is plotted over the recording, channel by channel. With two,
/// a run with real robots and the simulated run of the same experiment, it says robot by robot how far the paths, the spacing,
/// the slip and the delays differ. Robots are matched by name, and time 0 of both is the start of the run.
///
/// Example: slipstream compare RECORDING --robot robot.toml
///
/// Example: slipstream compare real.mcap simulated.mcap --report compare.html
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Recording: a folder of CSV files, or a bag (MCAP, SQLite or ROS 1; a file, or a folder as ROS 2 writes it)
    recording: PathBuf,
    /// Recording of a simulated run of the same experiment, which RECORDING is compared with
    simulated: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Robot model for all robots, or for the robot NAME: robot.toml, URDF or controller YAML; several of one robot fill
    /// what the others lack [default: the one in the recording]
    #[arg(long, value_name = "[NAME=]FILE")]
    robot: Vec<String>,
    /// Write the comparison of two recordings as JSON
    #[arg(long, value_name = "FILE", requires = "simulated")]
    json: Option<PathBuf>,
    /// Page to write [default: with one recording compare.html, with a number if that exists; with two none]
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    match &arguments.simulated {
        Some(simulated) => recorded::run(arguments, simulated),
        None => simulated::run(arguments),
    }
}
