//! `slipstream trial`: a blind test that scores the diagnosis on recordings with known effects.

mod arguments;
mod cases;
mod dry_run;
mod own;
mod temporary_folder;
mod text;
mod watched;

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use slipstream_bus::{InputError, Shard};
use slipstream_trial::TrialError;
use slipstream_trial::diagnosis_process::{DiagnosisProgram, DiagnosisRun};
use slipstream_trial::label::Labels;
use slipstream_trial::maker::PlannedCase;
use slipstream_trial::merge::merge;
use slipstream_trial::part::TrialPart;
use slipstream_trial::protocol::{Question, diagnose_all, questions, score};
use slipstream_trial::sealed_trial::SealedTrial;
use slipstream_trial::tally::{TrialReport, tally};

pub(crate) use self::arguments::Arguments;
use self::arguments::{Output, Part};
use self::cases::Cases;
use self::temporary_folder::temporary_folder;
use crate::command_line::command_line;
use crate::exit::{Error, Exit};
use crate::interrupt::Stop;
use crate::output_file::{place, write, write_json};
use crate::print::print_line;
use crate::progress;
use crate::shard_files;

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    if let Some(Part::Merge(asked)) = &arguments.part {
        let command = "slipstream trial --shard I/N --json FILE";
        let shards = shard_files::read(&asked.files, "a trial", command)?;
        return asked.output.write(&merge(&shards)?);
    }
    let excluded = arguments.without.iter().map(|id| ("--without", id));
    for (option, id) in excluded.chain(arguments.effect.iter().map(|id| ("--effect", id))) {
        if slipstream_sim::effects::find(id).is_none() {
            let place = format!("{option} {id}");
            return Err(
                InputError::new(place, "is not an effect", "see slipstream effects").into(),
            );
        }
    }
    // The diagnoses that run are killed at once; a case that is being made is not waited for.
    let stop = Stop::new(Duration::from_millis(500))?;
    if let Some(recording) = arguments.on.as_ref().filter(|_| arguments.watch) {
        return watched::run(&watched::Asked {
            on: recording,
            reading: &arguments.reading,
            robot: &arguments.robot,
            against: &arguments.against,
            without: &arguments.without,
            json: arguments.output.json.as_deref(),
            stop: &stop,
        });
    }
    if let Some(recording) = &arguments.on {
        let program = arguments.program()?;
        return own::run(&own::Asked {
            on: recording,
            reading: &arguments.reading,
            robot: &arguments.robot,
            out: arguments.out.as_deref(),
            without: &arguments.without,
            program: DiagnosisProgram {
                program: &program,
                limit: Duration::from_secs(arguments.limit_s),
                stop: &stop.asked,
            },
            stop: &stop,
            json: arguments.output.json.as_deref(),
            report: arguments.output.report.as_deref(),
        });
    }
    let cases = Cases::of(arguments)?;
    if arguments.dry_run {
        return dry_run::run(arguments, &cases, &stop.asked);
    }
    let shard = match &arguments.shard {
        None => Shard::WHOLE,
        Some(text) => {
            let shard: Shard = text.parse()?;
            shard.validate(cases.count(), "cases")?;
            shard
        }
    };
    let part = cases.part(arguments, shard)?;
    let file = arguments
        .output
        .json
        .as_deref()
        .filter(|_| arguments.resume);
    let is_it = |own: &TrialReport| own.part.as_ref() == Some(&part) && !own.interrupted;
    if let Some(report) = shard_files::kept(file, is_it) {
        return arguments.output.write(&report);
    }
    let report = match cases.of_shard(shard) {
        Cases::Labelled(folder, labels) => {
            score_existing(arguments, &folder, &labels, part, &stop)?
        }
        Cases::New(planned) => match score_new(arguments, &planned, part, &stop)? {
            Some(report) => report,
            None => return Ok(Exit::Done),
        },
    };
    arguments.output.write(&report)
}

impl Output {
    fn write(&self, report: &TrialReport) -> Result<Exit, Error> {
        if let Some(file) = &self.json {
            write_json(&place(file, report.interrupted), report)?;
        }
        if let Some(file) = &self.report {
            write(
                &place(file, report.interrupted),
                &slipstream_report::trial::page(report, &command_line()),
            )?;
        }
        text::print_report(report);
        Ok(text::ended(report.interrupted))
    }
}

/// A trial of existing recordings with labels.
fn score_existing(
    arguments: &Arguments,
    folder: &Path,
    labels: &Labels,
    part: TrialPart,
    stop: &Stop,
) -> Result<TrialReport, Error> {
    let questions = questions(labels, &arguments.without);
    let answers = diagnose_cases(arguments, folder, &questions, stop)?;
    let scores = score(labels, &questions, answers);
    Ok(tally(scores, Vec::new(), Some(part)))
}

/// A trial of new cases; `None` if they are only made and not diagnosed.
fn score_new(
    arguments: &Arguments,
    planned: &[PlannedCase],
    part: TrialPart,
    stop: &Stop,
) -> Result<Option<TrialReport>, Error> {
    let temporary = temporary_folder()?;
    let folder = arguments
        .out
        .clone()
        .unwrap_or_else(|| temporary.path().join("trial"));
    let bar = progress::bar(planned.len(), "made");
    let trial = SealedTrial::make(planned, &folder, || {
        bar.inc(1);
        if stop.asked.load(Ordering::Relaxed) {
            Err(TrialError::Interrupted)
        } else {
            Ok(())
        }
    });
    bar.finish_and_clear();
    let trial = trial?;
    if arguments.make_only {
        let labels = trial.open()?;
        print_line!(
            "{} cases with their labels: {}",
            labels.len(),
            folder.display()
        );
        return Ok(None);
    }
    let questions = trial.questions(&arguments.without);
    let answers = diagnose_cases(arguments, &folder, &questions, stop)?;
    let labels = trial.open()?;
    Ok(Some(tally(
        score(&labels, &questions, answers),
        trial.commitments(),
        Some(part),
    )))
}

/// Diagnoses every case, up to an interruption, and returns the answers in order.
fn diagnose_cases(
    arguments: &Arguments,
    folder: &Path,
    questions: &[Question],
    stop: &Stop,
) -> Result<Vec<DiagnosisRun>, Error> {
    let program = arguments.program()?;
    let program = DiagnosisProgram {
        program: &program,
        limit: Duration::from_secs(arguments.limit_s),
        stop: &stop.asked,
    };
    stop.keep();
    let bar = progress::bar(questions.len(), "diagnosed");
    let answers = diagnose_all(&program, folder, questions, |question, run| {
        bar.suspend(|| text::print_answer(question, run));
        bar.inc(1);
    });
    bar.finish_and_clear();
    Ok(answers?)
}
