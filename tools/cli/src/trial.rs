//! `slipstream trial`: is the diagnosis right where the truth is known?

use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use signal_hook::consts::{SIGINT, SIGTERM};
use slipstream_trial::TrialError;
use slipstream_trial::examine::Examiner;
use slipstream_trial::hold::hold;
use slipstream_trial::label::{self, Labels};
use slipstream_trial::mark::Outcome;
use slipstream_trial::tally::{Entry, Report, tally};

use crate::exit::{Error, Exit};
use crate::study::write_json;

/// Try the diagnosis on recordings whose truth is concealed from it
///
/// Each case is diagnosed in a process of its own that gets the recording and the nominal model
/// alone; then its label is opened and the answer is scored.
///
/// Example: slipstream trial --labels practice/labels.toml --json trial.json
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Labels beside the folders of recordings that they are for.
    #[arg(long, value_name = "FILE.toml")]
    labels: PathBuf,
    /// Only these cases of the labels.
    #[arg(long, value_name = "CASE", value_delimiter = ',')]
    only: Vec<String>,
    /// Take an effect out of the catalogue of every diagnosis.
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
    /// Longest time for one diagnosis (s).
    #[arg(long, value_name = "S", default_value_t = 300)]
    limit_s: u64,
    /// Write the scores to a file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let labels = chosen(label::read(&arguments.labels)?, arguments)?;
    let folder = arguments.labels.parent().unwrap_or(Path::new("."));
    let program = std::env::current_exe()
        .map_err(|error| Error::Failed(format!("this program's own file: {error}")))?;
    let stop = listen()?;
    let examiner = Examiner {
        program: &program,
        limit: Duration::from_secs(arguments.limit_s),
        stop: &stop,
    };
    let bar = bar(labels.len());
    let entries = hold(&examiner, folder, &labels, &arguments.without, |entry| {
        bar.suspend(|| say_case(entry));
        bar.inc(1);
    });
    bar.finish_and_clear();
    let report = tally(entries?, Vec::new());
    if let Some(file) = &arguments.json {
        write_json(file, &report)?;
    }
    say(&report);
    Ok(Exit::Done)
}

fn chosen(mut labels: Labels, arguments: &Arguments) -> Result<Labels, TrialError> {
    if let Some(name) = arguments
        .only
        .iter()
        .find(|name| !labels.contains_key(*name))
    {
        return Err(TrialError::Unusable {
            place: format!("--only {name}"),
            problem: format!("is no case of {}", arguments.labels.display()),
            remedy: "name cases as the labels do".to_owned(),
        });
    }
    labels.retain(|name, _| arguments.only.is_empty() || arguments.only.contains(name));
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

fn bar(cases: usize) -> ProgressBar {
    let target = if std::io::stderr().is_terminal() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(cases as u64), target);
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} cases, {eta} left") {
        bar.set_style(style);
    }
    bar
}

fn say_case(entry: &Entry) {
    let (name, outcome) = (&entry.case, entry.mark.outcome.name());
    let pairs: Vec<String> = entry
        .mark
        .pairs
        .iter()
        .map(|[truth, said]| format!("{truth} → {said}"))
        .collect();
    println!(
        "{name}  {outcome:<11} {:5.1} s  {}",
        entry.seconds,
        pairs.join(", ")
    );
    for remark in &entry.mark.remarks {
        println!("    {remark}");
    }
}

fn say(report: &Report) {
    println!(
        "\n{} cases, {} of them with nothing concealed",
        report.cases, report.nulls
    );
    for outcome in Outcome::ALL {
        let count = report
            .each
            .iter()
            .filter(|entry| entry.mark.outcome == outcome)
            .count();
        println!("  {:<12} {count}", outcome.name().replace('_', " "));
    }
    let figure = |what: &str, value: Option<f64>| {
        if let Some(value) = value {
            println!("{what} {value:.4}");
        }
    };
    figure(
        "share of 95 % intervals that hold the truth:",
        report.coverage95,
    );
    figure(
        "parameter error over the stated deviation (rms):",
        report.error_over_stated,
    );
    figure(
        "parameter error over the least possible deviation (rms):",
        report.error_over_least,
    );
    figure(
        "parameter error in proportion (median):",
        report.median_relative_error,
    );
    figure(
        "prediction error after over before (median):",
        report.held_out_ratio,
    );
    let [median, most] = report.seconds;
    println!("time for one diagnosis: {median:.1} s (median), {most:.1} s (most)");
}
