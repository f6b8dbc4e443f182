//! `slipstream trial`: scores the diagnosis on cases whose truth is concealed from it.

mod text;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::{Args, ValueEnum};
use signal_hook::consts::{SIGINT, SIGTERM};
use slipstream_bus::InputError;
use slipstream_trial::TrialError;
use slipstream_trial::diagnosis_process::DiagnosisProgram;
use slipstream_trial::label::{self, Labels};
use slipstream_trial::maker::Plan;
use slipstream_trial::protocol::{Question, diagnose_all, questions, score};
use slipstream_trial::sealed_trial::SealedTrial;
use slipstream_trial::tally::{TrialReport, tally};

use crate::command_line::command_line;
use crate::exit::{Error, Exit};
use crate::output_file::{write, write_json};
use crate::print::say;
use crate::progress;

/// Score the diagnosis on recordings whose truth is concealed from it
///
/// Cases are drawn from the seed and simulated by a second simulator that shares no code with the
/// plant. Before anything is diagnosed, recordings and a commitment to every label (SHA-256) are
/// written. Each case is diagnosed in a process of its own that gets only the recording and the
/// nominal model. Then the labels are opened, checked against the commitments, and the answers are
/// scored.
///
/// Example: slipstream trial --cases 200 --seed 1 --json trial.json --out trial
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Number of cases
    #[arg(
        long,
        value_name = "N",
        default_value_t = 20,
        conflicts_with = "labels"
    )]
    cases: usize,
    /// Seed of all random numbers
    #[arg(long, value_name = "S", default_value_t = 1, conflicts_with = "labels")]
    seed: u64,
    /// Cases to make: drawn at random, or every effect at several sizes
    #[arg(long, value_enum, default_value_t = Which::Sealed, conflicts_with = "labels")]
    plan: Which,
    /// Only cases that conceal this effect
    #[arg(long, value_name = "EFFECT", conflicts_with = "labels")]
    effect: Option<String>,
    /// Write recordings, models and labels, and diagnose nothing
    #[arg(long, requires = "out", conflicts_with_all = ["labels", "json", "report"])]
    make_only: bool,
    /// New folder for recordings, commitments and, at the end, labels
    #[arg(long, value_name = "FOLDER", conflicts_with = "labels")]
    out: Option<PathBuf>,
    /// Labels of recordings made elsewhere, in the folder of these recordings
    #[arg(long, value_name = "FILE.toml")]
    labels: Option<PathBuf>,
    /// Only these cases of the labels
    #[arg(long, value_name = "CASE", value_delimiter = ',', requires = "labels")]
    only: Vec<String>,
    /// Leave an effect out of the catalogue of every diagnosis
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
    /// Score another program, called as `PROGRAM diagnose …`
    #[arg(long, value_name = "PROGRAM")]
    with: Option<PathBuf>,
    /// Time limit of one diagnosis (s)
    #[arg(long, value_name = "S", default_value_t = 300)]
    limit_s: u64,
    /// Write the scores as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with the scores
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Which {
    /// `--cases` cases drawn from the seed
    Sealed,
    /// Every effect at three sizes, nulls, pairs, and physics outside the vocabulary
    Battery,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let excluded = arguments.without.iter().map(|id| ("--without", id));
    for (option, id) in excluded.chain(arguments.effect.iter().map(|id| ("--effect", id))) {
        if slipstream_sim::effects::find(id).is_none() {
            let place = format!("{option} {id}");
            return Err(
                InputError::new(place, "is not an effect", "see slipstream effects").into(),
            );
        }
    }
    let stop = listen()?;
    let report = match &arguments.labels {
        Some(file) => labelled(arguments, file, &stop)?,
        None => match drawn(arguments, &stop)? {
            Some(report) => report,
            None => return Ok(Exit::Done),
        },
    };
    if let Some(file) = &arguments.json {
        write_json(file, &report)?;
    }
    if let Some(file) = &arguments.report {
        let page = slipstream_trial::page::page(&report, &command_line())
            .map_err(|error| Error::Failed(error.to_string()))?;
        write(file, &page)?;
    }
    text::say(&report);
    Ok(Exit::Done)
}

/// A trial of recordings made elsewhere.
fn labelled(arguments: &Arguments, file: &Path, stop: &AtomicBool) -> Result<TrialReport, Error> {
    let labels = chosen(label::read(file)?, &arguments.only, file)?;
    let folder = file.parent().unwrap_or(Path::new("."));
    let questions = questions(&labels, &arguments.without);
    let answers = answers(arguments, folder, &questions, stop)?;
    Ok(tally(score(&labels, &questions, answers), Vec::new()))
}

/// A trial of cases drawn here; nothing where they are only made.
fn drawn(arguments: &Arguments, stop: &AtomicBool) -> Result<Option<TrialReport>, Error> {
    let plan = match arguments.plan {
        Which::Sealed => Plan::sealed(arguments.cases, arguments.seed),
        Which::Battery => Plan::battery(arguments.seed),
    };
    let plan = match &arguments.effect {
        Some(id) => plan.with_effect(id),
        None => plan,
    };
    let passing = tempfile::tempdir()
        .map_err(|error| Error::Failed(format!("a temporary folder: {error}")))?;
    let folder = arguments
        .out
        .clone()
        .unwrap_or_else(|| passing.path().join("trial"));
    let bar = progress::bar(plan.cases().count(), "made");
    let trial = SealedTrial::make(&plan, &folder, || {
        bar.inc(1);
        if stop.load(Ordering::Relaxed) {
            Err(TrialError::Interrupted)
        } else {
            Ok(())
        }
    });
    bar.finish_and_clear();
    let trial = trial?;
    if arguments.make_only {
        let labels = trial.open()?;
        say!(
            "{} cases with their labels: {}",
            labels.len(),
            folder.display()
        );
        return Ok(None);
    }
    let questions = trial.questions(&arguments.without);
    let answers = answers(arguments, &folder, &questions, stop)?;
    let labels = trial.open()?;
    Ok(Some(tally(
        score(&labels, &questions, answers),
        trial.commitments(),
    )))
}

fn answers(
    arguments: &Arguments,
    folder: &Path,
    questions: &[Question],
    stop: &AtomicBool,
) -> Result<Vec<slipstream_trial::diagnosis_process::DiagnosisRun>, Error> {
    let program = match &arguments.with {
        // the diagnosis works in another folder
        Some(program) => std::path::absolute(program),
        None => std::env::current_exe(),
    };
    let program =
        program.map_err(|error| Error::Failed(format!("the program that diagnoses: {error}")))?;
    let program = DiagnosisProgram {
        program: &program,
        limit: Duration::from_secs(arguments.limit_s),
        stop,
    };
    let bar = progress::bar(questions.len(), "diagnosed");
    let answers = diagnose_all(&program, folder, questions, |question, run| {
        bar.suspend(|| text::say_answer(question, run));
        bar.inc(1);
    });
    bar.finish_and_clear();
    Ok(answers?)
}

fn chosen(mut labels: Labels, only: &[String], file: &Path) -> Result<Labels, TrialError> {
    if let Some(name) = only.iter().find(|name| !labels.contains_key(*name)) {
        return Err(InputError::new(
            format!("--only {name}"),
            format!("is no case of {}", file.display()),
            "name cases as the labels do",
        )
        .into());
    }
    labels.retain(|name, _| only.is_empty() || only.contains(name));
    Ok(labels)
}

/// A flag that Ctrl-C sets.
fn listen() -> Result<Arc<AtomicBool>, Error> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| Error::Failed(format!("cannot listen to signals: {error}")))?;
    }
    Ok(stop)
}
