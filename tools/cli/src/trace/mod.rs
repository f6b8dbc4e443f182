//! `slipstream trace`: latency of position messages, stage by stage.

mod table;

use std::path::{Path, PathBuf};

use clap::Args;
use slipstream_report::trace::Latency;
use slipstream_trace::TraceReading;

use crate::command_line::command_line;
use crate::exit::{Error, Exit};
use crate::output_file;
use crate::print::{self, note_line};
use crate::provenance;

/// Show the latency of each link, stage by stage, from the encoder sample to the applied torque
///
/// Example: slipstream trace platoon.mcap --perfetto platoon.json, then open it in ui.perfetto.dev
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// MCAP file written by `slipstream run`
    recording: PathBuf,
    /// Compare with another run and show which stages differ
    #[arg(long, value_name = "OTHER")]
    against: Option<PathBuf>,
    /// Write the answer as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write every tick and message as a Chrome trace for Perfetto
    #[arg(long, value_name = "FILE")]
    perfetto: Option<PathBuf>,
    /// Write the delays of the links as round trips for links.trace (several links: FILE.FROM-TO.csv
    /// each)
    #[arg(long, value_name = "FILE.csv")]
    rtt: Option<PathBuf>,
    /// Write a page: stages of each link, age of the positions in use, deadlines
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let reading = read(&arguments.recording)?;
    let mut answer = slipstream_trace::answer(&reading.log, &reading.robots);
    if let Some(other) = &arguments.against {
        let other = read(other)?;
        let changes = slipstream_trace::against(&reading.log, &other.log, &reading.robots);
        answer.against = Some(changes);
        other.log.check()?;
    }
    reading.log.check()?;
    if let Some(file) = &arguments.json {
        output_file::write_json(file, &answer)?;
    }
    if let Some(file) = &arguments.perfetto {
        let timeline = slipstream_trace::timeline(&reading.log, &reading.robots);
        output_file::write_json(file, &timeline)?;
    }
    if let Some(file) = &arguments.rtt {
        write_round_trips(file, &reading)?;
    }
    if let Some(file) = &arguments.report {
        let name = arguments.recording.file_name().unwrap_or_default();
        let page = slipstream_report::trace::page(&Latency {
            subject: name.to_string_lossy().into_owned(),
            answer: &answer,
            reading: &reading,
            command_line: command_line(),
            facts: provenance::facts(std::slice::from_ref(&arguments.recording), &[], ""),
        });
        output_file::write(file, &page)?;
    }
    reading.log.check()?;
    let first = slipstream_report::trace::headline(&answer);
    let then = slipstream_report::trace::lead_text(&answer);
    print::out(format_args!("{first}\n{then}\n\n{}", table::table(&answer)));
    Ok(Exit::Done)
}

fn write_round_trips(file: &Path, reading: &TraceReading) -> Result<(), Error> {
    let links = slipstream_trace::round_trips(&reading.log);
    for link in &links {
        let [from, to] = [link.from, link.to].map(|robot| reading.name_of(robot));
        let own = file.with_extension(format!("{from}-{to}.csv"));
        output_file::write(if links.len() == 1 { file } else { &own }, &link.csv)?;
    }
    Ok(())
}

fn read(recording: &Path) -> Result<TraceReading, Error> {
    let reading = slipstream_trace::read(recording)?;
    for warning in &reading.warnings {
        note_line!("{warning}");
    }
    Ok(reading)
}
