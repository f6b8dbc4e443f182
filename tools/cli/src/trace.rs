//! `slipstream trace`: latency, stage by stage.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use slipstream_trace::{Age, Answer, Figures, Hop, Incomplete};

use crate::exit::{Error, Exit};

/// Show where the time of each position between robots went, from the encoder sample to the torque
///
/// Example: slipstream trace platoon.mcap --perfetto platoon.json, then open it in ui.perfetto.dev
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// An MCAP file that `slipstream run` wrote
    recording: PathBuf,
    /// Write the answer to a file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write every tick and message as a Chrome trace, for Perfetto
    #[arg(long, value_name = "FILE")]
    perfetto: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let reading = slipstream_trace::read(&arguments.recording)?;
    for warning in &reading.warnings {
        eprintln!("{warning}");
    }
    let answer = slipstream_trace::answer(&reading.log, &reading.robots);
    if let Some(file) = &arguments.json {
        write(file, &answer)?;
    }
    if let Some(file) = &arguments.perfetto {
        let timeline = slipstream_trace::timeline(&reading.log, &reading.robots);
        write(file, &timeline)?;
    }
    // Who has closed the pipe does not want it.
    let _ = std::io::stdout().write_all(table(&answer).as_bytes());
    Ok(Exit::Done)
}

fn write(file: &Path, value: &impl serde::Serialize) -> Result<(), Error> {
    let failed = |e: String| Error::Failed(format!("{}: cannot be written: {e}", file.display()));
    let json = serde_json::to_string_pretty(value).map_err(|e| failed(e.to_string()))?;
    std::fs::write(file, json + "\n").map_err(|e| failed(e.to_string()))
}

/// The answer in words. Writing to a string cannot fail.
fn table(answer: &Answer) -> String {
    let mut text = String::new();
    for hop in &answer.hops {
        hop_table(&mut text, hop);
    }
    let ages = [
        ("Age of what a torque goes by", &answer.platoon),
        ("Age of what an outer tick goes by", &answer.at_outer_ticks),
    ];
    for (title, ages) in ages.into_iter().filter(|(_, ages)| !ages.is_empty()) {
        let _ = writeln!(text, "{title:34}      p50        p99        max (ms)");
        for Age {
            from, to, figures, ..
        } in ages
        {
            row(&mut text, &format!("  {from}, used by {to}"), figures);
        }
        text.push('\n');
    }
    let _ = writeln!(
        text,
        "Ticks run late by                       p50        p99        max (ms)"
    );
    for figures in &answer.loops {
        let (process, name, ticks) = (&figures.process, figures.name, figures.ticks);
        let left_out = match figures.left_out {
            0 => String::new(),
            left_out => format!(", {left_out} left out"),
        };
        let what = format!("  {process} {name}: {ticks}{left_out}");
        row(&mut text, &what, &figures.late);
    }
    text
}

fn hop_table(text: &mut String, hop: &Hop) {
    let (from, to) = (&hop.from, &hop.to);
    let (sent, used) = (hop.sent, hop.messages);
    let _ = writeln!(
        text,
        "{from} → {to}: {sent} sent, {used} used{}",
        others(&hop.incomplete)
    );
    if let Some(end_to_end) = &hop.end_to_end {
        let _ = writeln!(text, "{:34}      p50        p99        max (ms)", "");
        for stage in &hop.stages {
            row(text, &format!("  {}", stage.stage), &stage.figures);
        }
        row(text, "  end to end", end_to_end);
    }
    text.push('\n');
}

fn others(incomplete: &Incomplete) -> String {
    let counts = [
        (incomplete.lost, "lost"),
        (incomplete.superseded, "superseded"),
        (incomplete.stale, "stale"),
        (incomplete.overwritten, "overwritten"),
        (incomplete.under_way, "under way at the end"),
        (incomplete.receiver_died, "whose receiver died"),
        (incomplete.untold, "with missing records"),
    ];
    let told = counts.into_iter().filter(|(count, _)| *count > 0);
    told.map(|(count, what)| format!(", {count} {what}"))
        .collect()
}

fn row(text: &mut String, what: &str, figures: &Figures) {
    let [p50, p99, max] = [figures.p50_s, figures.p99_s, figures.max_s].map(|s| s * 1e3);
    let _ = writeln!(text, "{what:34} {p50:10.4} {p99:10.4} {max:10.4}");
}
