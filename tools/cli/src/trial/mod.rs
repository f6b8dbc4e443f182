//! `slipstream trial`: a blind test that scores the diagnosis on recordings with known effects.

mod own;
mod text;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::{Args, ValueEnum};
use slipstream_bus::InputError;
use slipstream_recording::output::OutputFolder;
use slipstream_trial::TrialError;
use slipstream_trial::diagnosis_process::DiagnosisProgram;
use slipstream_trial::label::{self, Labels};
use slipstream_trial::maker::Plan;
use slipstream_trial::protocol::{Question, diagnose_all, questions, score};
use slipstream_trial::sealed_trial::SealedTrial;
use slipstream_trial::tally::{TrialReport, tally};

use crate::command_line::command_line;
use crate::exit::{Error, Exit};
use crate::interrupt;
use crate::output_file::{write, write_json};
use crate::print::print_line;
use crate::progress;
use crate::reading::Reading;

/// Score the diagnosis in a blind test, on recordings with known effects
///
/// Cases are drawn from the seed and simulated by a second simulator that shares no code with the
/// plant. Before anything is diagnosed, the recordings and a commitment to every label (SHA-256) are
/// written. Each case is diagnosed in its own process, which gets only the recording and the nominal
/// model. Then the labels are opened and checked against the commitments, and the answers are scored.
///
/// With --on, known changes are put into copies of a recording of your own, and none into others; each copy
/// is diagnosed against the original. It shows what would be found on your robot, down to which size.
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
    /// How the cases are chosen
    #[arg(long, value_enum, default_value_t = PlanKind::Sealed, conflicts_with = "labels")]
    plan: PlanKind,
    /// Only cases with this effect
    #[arg(long, value_name = "EFFECT", conflicts_with = "labels")]
    effect: Option<String>,
    /// Write recordings, models and labels, but diagnose nothing
    #[arg(long, requires = "out", conflicts_with_all = ["labels", "json", "report"])]
    make_only: bool,
    /// New folder for the recordings, commitments and, at the end, labels [default: a temporary one]
    #[arg(long, value_name = "FOLDER", conflicts_with = "labels")]
    out: Option<PathBuf>,
    /// Put changes into copies of this recording instead, and diagnose them against it
    #[arg(long, value_name = "RECORDING", conflicts_with_all = ["cases", "seed", "plan", "effect", "make_only", "labels"])]
    on: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Robot model of that recording: robot.toml, URDF or diff_drive_controller YAML [default: the one in the recording]
    #[arg(long, value_name = "[NAME=]FILE", requires = "on")]
    robot: Vec<String>,
    /// Score existing recordings instead: their labels, in the folder of the recordings
    #[arg(long, value_name = "FILE.toml")]
    labels: Option<PathBuf>,
    /// Only these cases of the labels, separated by commas
    #[arg(long, value_name = "CASE", value_delimiter = ',', requires = "labels")]
    only: Vec<String>,
    /// Leave an effect out of the catalogue of every diagnosis; may be repeated
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
    /// Score another program, called as PROGRAM diagnose … [default: slipstream]
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

/// How the cases of a trial are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PlanKind {
    /// N cases drawn at random from the seed
    Sealed,
    /// Every effect at three sizes, pairs of effects, no effect, and physics outside the vocabulary
    Battery,
    /// Robots without known masses, under commanded speeds
    Kinematic,
    /// Process noise: no effect, single effects and pairs
    Noise,
    /// Recordings that start inside what acts
    Starts,
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
    // The diagnoses that run are killed at once; a case that is being made is not waited for.
    let stop = interrupt::stop_flag(Some(Duration::from_millis(500)))?;
    if let Some(recording) = &arguments.on {
        let program = program(arguments)?;
        return own::run(&own::Asked {
            on: recording,
            reading: &arguments.reading,
            robot: &arguments.robot,
            out: arguments.out.as_deref(),
            without: &arguments.without,
            program: DiagnosisProgram {
                program: &program,
                limit: Duration::from_secs(arguments.limit_s),
                stop: &stop,
            },
            json: arguments.json.as_deref(),
            report: arguments.report.as_deref(),
        });
    }
    let report = match &arguments.labels {
        Some(file) => score_existing(arguments, file, &stop)?,
        None => match score_new(arguments, &stop)? {
            Some(report) => report,
            None => return Ok(Exit::Done),
        },
    };
    if let Some(file) = &arguments.json {
        write_json(file, &report)?;
    }
    if let Some(file) = &arguments.report {
        write(
            file,
            &slipstream_report::trial::page(&report, &command_line()),
        )?;
    }
    text::print_report(&report);
    Ok(Exit::Done)
}

/// A trial of existing recordings with labels.
fn score_existing(
    arguments: &Arguments,
    file: &Path,
    stop: &AtomicBool,
) -> Result<TrialReport, Error> {
    let labels = select(label::read(file)?, &arguments.only, file)?;
    let folder = file.parent().unwrap_or(Path::new("."));
    let questions = questions(&labels, &arguments.without);
    let answers = diagnose_cases(arguments, folder, &questions, stop)?;
    Ok(tally(score(&labels, &questions, answers), Vec::new()))
}

/// A trial of new cases; `None` if they are only made and not diagnosed.
fn score_new(arguments: &Arguments, stop: &AtomicBool) -> Result<Option<TrialReport>, Error> {
    let plan = match arguments.plan {
        PlanKind::Sealed => Plan::sealed(arguments.cases, arguments.seed),
        PlanKind::Battery => Plan::battery(arguments.seed),
        PlanKind::Kinematic => Plan::kinematic(arguments.seed),
        PlanKind::Noise => Plan::noise(arguments.seed),
        PlanKind::Starts => Plan::starts(arguments.seed),
    };
    let plan = match &arguments.effect {
        Some(id) => plan.with_effect(id),
        None => plan,
    };
    let name = format!("slipstream-trial-{}", std::process::id());
    let temporary = OutputFolder::create(&std::env::temp_dir().join(name))?;
    let folder = arguments
        .out
        .clone()
        .unwrap_or_else(|| temporary.path().join("trial"));
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
    )))
}

/// Diagnoses every case and returns the answers in order.
fn diagnose_cases(
    arguments: &Arguments,
    folder: &Path,
    questions: &[Question],
    stop: &AtomicBool,
) -> Result<Vec<slipstream_trial::diagnosis_process::DiagnosisRun>, Error> {
    let program = program(arguments)?;
    let program = DiagnosisProgram {
        program: &program,
        limit: Duration::from_secs(arguments.limit_s),
        stop,
    };
    let bar = progress::bar(questions.len(), "diagnosed");
    let answers = diagnose_all(&program, folder, questions, |question, run| {
        bar.suspend(|| text::print_answer(question, run));
        bar.inc(1);
    });
    bar.finish_and_clear();
    Ok(answers?)
}

/// The program that diagnoses.
fn program(arguments: &Arguments) -> Result<PathBuf, Error> {
    let program = match &arguments.with {
        // The diagnosis runs in another folder.
        Some(program) => std::path::absolute(program),
        None => std::env::current_exe(),
    };
    program.map_err(|error| {
        Error::Failed(format!(
            "failed to find the program that diagnoses: {error}"
        ))
    })
}

/// The labels of the cases in `only`; all if it is empty.
fn select(mut labels: Labels, only: &[String], file: &Path) -> Result<Labels, TrialError> {
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
