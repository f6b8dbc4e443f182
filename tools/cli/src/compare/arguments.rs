//! Arguments of `slipstream compare`.

use std::path::PathBuf;

use clap::Args;

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
    pub(super) recording: PathBuf,
    /// Recording of a simulated run of the same experiment, which RECORDING is compared with
    pub(super) simulated: Option<PathBuf>,
    #[command(flatten)]
    pub(super) reading: Reading,
    /// Robot model for all robots, or for the robot NAME: robot.toml, URDF or controller YAML; several of one robot fill
    /// what the others lack [default: the one in the recording]
    #[arg(long, value_name = "[NAME=]FILE")]
    pub(super) robot: Vec<String>,
    /// Write the comparison of two recordings as JSON
    #[arg(long, value_name = "FILE", requires = "simulated")]
    pub(super) json: Option<PathBuf>,
    /// Page to write [default: with one recording compare.html, with a number if that exists; with two none]
    #[arg(long, value_name = "FILE.html")]
    pub(super) report: Option<PathBuf>,
}
