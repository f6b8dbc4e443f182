//! `slipstream check`: data quality of a recording, and what can be concluded from it.

use std::path::PathBuf;

use clap::Args;
use console::Style;
use slipstream_recording::{Finding, Severity};

use crate::exit::{Error, Exit};
use crate::models::Models;
use crate::print::{self, print_line};
use crate::reading::{Guesses, Reading};

/// Check a recording: rates, gaps, units, swapped or reversed wheels, clocks
///
/// Ends with exit code 2 if it finds an ERROR, with which a diagnosis would be wrong.
///
/// Example: slipstream check RECORDING --robot robot.toml
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Recording: a folder of CSV files, or a bag (MCAP, SQLite or ROS 1; a file, or a folder as ROS 2 writes it)
    recording: PathBuf,
    /// Robot model: robot.toml, URDF or controller YAML; several fill what the others lack [default: the one in the
    /// recording]
    #[arg(long, value_name = "FILE")]
    robot: Vec<PathBuf>,
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
    let models = Models::of_one(&arguments.robot)?;
    let to_write = arguments.write_topics.as_ref();
    if let Some(file) = to_write.or(arguments.write_columns.as_ref()) {
        let map = slipstream_recording::draft_map(&arguments.recording, &models.wheel_joints())?;
        crate::output_file::write(file, &map)?;
        print_line!("{}", file.display());
        return Ok(Exit::Done);
    }
    let reading = &arguments.reading;
    let spooled = reading.spool(&arguments.recording, &models, Guesses::Whole)?;
    let report = spooled.check(models.of("").as_ref())?;
    print::out(format_args!("{}", with_colours(&report.to_string())));
    if let Some(path) = &arguments.json {
        crate::output_file::write_json(path, &report)?;
    }
    let is_wrong = |finding: &Finding| finding.severity == Severity::Error;
    Ok(match report.findings.iter().any(is_wrong) {
        true => Exit::InvalidInput,
        false => Exit::Done,
    })
}

/// The report with its severities in colours, where results are coloured.
fn with_colours(report: &str) -> String {
    let severities = [
        ("  ERROR ", Style::new().red().bold()),
        ("  warning ", Style::new().yellow()),
    ];
    let line = |line: &str| {
        let own = severities.iter().find(|(begin, _)| line.starts_with(begin));
        match own {
            Some((begin, style)) => print::styled(begin, style) + &line[begin.len()..],
            None => line.to_owned(),
        }
    };
    report.lines().map(|own| line(own) + "\n").collect()
}
