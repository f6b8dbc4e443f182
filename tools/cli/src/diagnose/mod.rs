//! `slipstream diagnose`: finds what a robot model lacks, from a recording.

mod charts;
mod page;
mod points;
mod text;

use std::path::PathBuf;

use clap::Args;
use slipstream_diagnose::{
    Answer, Illustrated, InputError, Request, diagnose, diagnose_with_figures,
};
use slipstream_recording::robot_toml;

use crate::exit::{Error, Exit};
use crate::models::Models;
use crate::output_file;
use crate::print::{complain, say};
use crate::progress;

/// Find what a robot model lacks, from a recording
///
/// Prints where model and recording differ, which effects of the catalogue the model lacks, their
/// parameters and 95 % intervals; or that nothing is missing; or that something is missing that the
/// catalogue does not hold, and what it depends on.
///
/// Example: slipstream diagnose RECORDING --robot robot.toml --improved better.toml
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Folder with recording.toml, or an MCAP file; several are runs of the same machines
    #[arg(required = true)]
    recording: Vec<PathBuf>,
    /// Robot model for all robots, or for the robot NAME [default: the one in the recording]
    #[arg(long, value_name = "[NAME=]FILE.toml")]
    robot: Vec<String>,
    /// Write the answer as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with the answer and its figures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the model with the found effects added (several robots: FILE.NAME.toml each)
    #[arg(long, value_name = "FILE.toml")]
    improved: Option<PathBuf>,
    /// Ignore everything measured from A to B seconds
    #[arg(long, value_name = "A:B", value_parser = time_span)]
    exclude_time: Vec<[f64; 2]>,
    /// Leave an effect out of the catalogue
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    for id in &arguments.without {
        if slipstream_sim::effects::find(id).is_none() {
            let place = format!("--without {id}");
            return Err(
                InputError::new(place, "is not an effect", "see slipstream effects").into(),
            );
        }
    }
    let mut recordings = Vec::new();
    for path in &arguments.recording {
        let import = slipstream_recording::read(path)?;
        for warning in &import.warnings {
            complain!("{warning}");
        }
        recordings.push(import.recording);
    }
    let models = Models::read(&arguments.robot)?;
    let line = progress::line();
    let request = Request {
        recordings: &recordings,
        model_of: &|robot| models.of(robot),
        excluded: &arguments.without,
        excluded_s: &arguments.exclude_time,
        progress: &|step| line.set_message(step.to_owned()),
    };
    let done = examine(&request, arguments.report.is_some());
    line.finish_and_clear();
    let (answer, improved, figures) = done?;
    if let Some(file) = &arguments.json {
        output_file::write_json(file, &answer)?;
    }
    if let Some(file) = &arguments.report {
        let names: Vec<&str> = recordings
            .iter()
            .map(|recording| recording.name.as_str())
            .collect();
        let page = page::page(&names.join(", "), &answer, &figures);
        let page = page.map_err(|e| Error::Failed(format!("{}: {e}", file.display())))?;
        output_file::write(file, &page)?;
    }
    if let Some(file) = &arguments.improved {
        for (name, model) in &improved {
            let file = if improved.len() == 1 {
                file.clone()
            } else {
                file.with_extension(format!("{name}.toml"))
            };
            output_file::write(&file, &robot_toml::to_text(model))?;
        }
    }
    say(&answer);
    Ok(Exit::Done)
}

/// Parses a time span `A:B` (s).
fn time_span(text: &str) -> Result<[f64; 2], String> {
    let ends = text
        .split_once(':')
        .and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
    ends.filter(|[a, b]| a < b)
        .ok_or_else(|| "give two times in seconds, such as 12.5:14".to_owned())
}

/// The diagnosis, with figures if a page is written.
fn examine(request: &Request<'_>, with_figures: bool) -> Result<Illustrated, InputError> {
    if with_figures {
        return diagnose_with_figures(request);
    }
    let (answer, improved) = diagnose(request)?;
    Ok((answer, improved, Vec::new()))
}

fn say(answer: &Answer) {
    let held = &answer.held_out;
    say!("{}.", text::verdict(answer.verdict));
    for warning in &answer.warnings {
        say!("Warning: {}.", text::warning(warning));
    }
    for finding in &answer.findings {
        say!("\n{}", finding.statement);
    }
    let said = |shape: &str| {
        answer
            .findings
            .iter()
            .any(|f| f.shape.as_deref() == Some(shape))
    };
    for left in answer.unexplained.iter().filter(|left| !said(&left.shape)) {
        say!("\nRobot {}, {}: {}", left.robot, left.channel, left.shape);
    }
    say!(
        "\nPrediction error over 5 s: {:.2} sensor standard deviations before, {:.2} after (noise alone: 1).",
        held.nrmse_before,
        held.nrmse_after
    );
}
