//! `slipstream trial --on`: changes put into copies of a recording that exists.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use slipstream_bus::InputError;
use slipstream_recording::output::OutputFolder;
use slipstream_trial::diagnosis_process::{DiagnosisInput, DiagnosisProgram};
use slipstream_trial::own::{OwnReport, make, score};

use super::{Arguments, program, text};
use crate::command_line::command_line;
use crate::exit::{Error, Exit};
use crate::models::Models;
use crate::output_file::{write, write_json};
use crate::print::{eprint_line, print_line};
use crate::progress;

/// Runs the command.
pub(super) fn run(arguments: &Arguments, path: &Path, stop: &AtomicBool) -> Result<Exit, Error> {
    let import = slipstream_recording::read(path)?;
    for warning in &import.warnings {
        eprint_line!("{warning}");
    }
    let recording = import.recording;
    let models = Models::read(&arguments.robot)?;
    let first = recording.robots.first().map(|robot| robot.name.as_str());
    let model = first.and_then(|name| models.of(name));
    let model = model.or_else(|| recording.model.clone()).ok_or_else(|| {
        let remedy = "give one with --robot robot.toml";
        InputError::new(path.display().to_string(), "has no model", remedy)
    })?;
    let name = format!("slipstream-trial-{}", std::process::id());
    let temporary = OutputFolder::create(&std::env::temp_dir().join(name))?;
    let folder = match &arguments.out {
        Some(folder) => {
            std::fs::create_dir_all(folder)
                .map_err(|error| Error::Failed(format!("{}: {error}", folder.display())))?;
            folder.clone()
        }
        None => temporary.path().to_owned(),
    };
    let trial = make(&recording, &model, &folder)?;
    let program = program(arguments)?;
    let program = DiagnosisProgram {
        program: &program,
        limit: Duration::from_secs(arguments.limit_s),
        stop,
    };
    let bar = progress::bar(trial.cases.len(), "diagnosed");
    let mut answers = Vec::new();
    for case in &trial.cases {
        answers.push(program.diagnose(&DiagnosisInput {
            recording: &case.folders[0],
            against: Some(&case.folders[1]),
            model: &trial.model,
            without: &arguments.without,
        })?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let report = score(&recording.name, &trial.cases, answers);
    if let Some(file) = &arguments.json {
        write_json(file, &report)?;
    }
    if let Some(file) = &arguments.report {
        write(
            file,
            &slipstream_report::trial::own_page(&report, &command_line()),
        )?;
    }
    print(&report);
    Ok(Exit::Done)
}

fn print(report: &OwnReport) {
    text::print_report(&report.trial);
    print_line!(
        "\nWhat would be found on this robot, as a change since {}:",
        report.on
    );
    for own in &report.detectable {
        let smallest = own
            .smallest
            .map_or("not at the sizes tried".to_owned(), |size| {
                format!("from {}", short(size))
            });
        let tried: Vec<String> = own
            .tried
            .iter()
            .map(|(size, found)| format!("{} {}", short(*size), if *found { "yes" } else { "no" }))
            .collect();
        print_line!(
            "  {:<18} {:<13} {smallest}  ({})",
            own.effect,
            own.parameter,
            tried.join(", ")
        );
    }
}

/// A number with three digits that count.
fn short(value: f64) -> String {
    let digits = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.digits$}")
}
