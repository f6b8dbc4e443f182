//! `slipstream trial --on`: changes put into copies of a recording that exists.

use std::path::Path;

use slipstream_bus::InputError;
use slipstream_trial::diagnosis_process::{DiagnosisInput, DiagnosisProgram};
use slipstream_trial::own::{OwnReport, make, score};
use slipstream_trial::protocol::until_interrupted;

use super::temporary_folder::temporary_folder;
use super::text;
use crate::command_line::command_line;
use crate::exit::{Error, Exit};
use crate::interrupt::Stop;
use crate::models::Models;
use crate::output_file::{place, write, write_json};
use crate::print::print_line;
use crate::progress;
use crate::reading::Reading;

/// What is asked.
pub(super) struct Asked<'a> {
    /// The recording.
    pub(super) on: &'a Path,
    /// How to read it.
    pub(super) reading: &'a Reading,
    /// Robot models.
    pub(super) robot: &'a [String],
    /// Folder for the copies.
    pub(super) out: Option<&'a Path>,
    /// Effects that no diagnosis tries.
    pub(super) without: &'a [String],
    /// The program that diagnoses.
    pub(super) program: DiagnosisProgram<'a>,
    pub(super) stop: &'a Stop,
    /// Where the scores go, and a page with them.
    pub(super) json: Option<&'a Path>,
    pub(super) report: Option<&'a Path>,
}

/// Runs the command.
pub(super) fn run(asked: &Asked<'_>) -> Result<Exit, Error> {
    let path = asked.on;
    let models = Models::read(asked.robot)?;
    let recording = asked.reading.read(path, &models)?.recording;
    let first = recording.robots.first().map(|robot| robot.name.as_str());
    let model = first.and_then(|name| models.of(name));
    let model = model.or_else(|| recording.model.clone()).ok_or_else(|| {
        let remedy = "give one with --robot robot.toml";
        InputError::new(path.display().to_string(), "has no model", remedy)
    })?;
    let temporary = temporary_folder()?;
    let folder = match asked.out {
        Some(folder) => {
            let made = std::fs::create_dir_all(folder);
            made.map_err(|error| Error::Failed(format!("{}: {error}", folder.display())))?;
            folder
        }
        None => temporary.path(),
    };
    let trial = make(&recording, &model, folder)?;
    let bar = progress::bar(trial.cases.len(), "diagnosed");
    asked.stop.keep();
    let answers = until_interrupted(&trial.cases, |case| {
        let run = asked.program.diagnose(&DiagnosisInput {
            recording: &case.folders[0],
            against: Some(&case.folders[1]),
            model: &trial.model,
            without: asked.without,
        })?;
        bar.inc(1);
        Ok(run)
    })?;
    bar.finish_and_clear();
    let report = score(&recording.name, &trial.cases, answers);
    let interrupted = report.trial.interrupted;
    if let Some(file) = asked.json {
        write_json(&place(file, interrupted), &report)?;
    }
    if let Some(file) = asked.report {
        write(
            &place(file, interrupted),
            &slipstream_report::trial::own_page(&report, &command_line()),
        )?;
    }
    print(&report);
    Ok(text::ended(interrupted))
}

fn print(report: &OwnReport) {
    text::print_report(&report.trial);
    let [whole, exact, hidden] = report.whole();
    print_line!(
        "\nOf {whole} changes in whole copies {exact} were named with their size, {hidden} are out of sight:"
    );
    print_line!("their diagnosis says that it would not see a change of that size.");
    if hidden > 0 {
        print_line!("  out of sight: {}", report.out_of_sight.join(", "));
    }
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
