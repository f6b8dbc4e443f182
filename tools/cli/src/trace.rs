//! `slipstream trace`: latency, stage by stage.

mod page;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use slipstream_trace::{Age, Answer, Hop, HopChange, Incomplete, Percentiles, Reading};

use crate::exit::{Error, Exit};
use crate::output_file;
use crate::print::{self, complain};

/// Show where the time of each position between robots went, from the encoder sample to the torque
///
/// Example: slipstream trace platoon.mcap --perfetto platoon.json, then open it in ui.perfetto.dev
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// An MCAP file that `slipstream run` wrote
    recording: PathBuf,
    /// Say which stages differ from another run
    #[arg(long, value_name = "OTHER")]
    against: Option<PathBuf>,
    /// Write the answer to a file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write every tick and message as a Chrome trace, for Perfetto
    #[arg(long, value_name = "FILE")]
    perfetto: Option<PathBuf>,
    /// Write the links' delays as round trips, to be replayed with links.trace (several links:
    /// FILE.FROM-TO.csv each)
    #[arg(long, value_name = "FILE.csv")]
    rtt: Option<PathBuf>,
    /// Write a page with the stages side by side and how end-to-end latency is distributed
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
    }
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
        let page = page::page(&arguments.recording, &answer, &reading);
        let page = page.map_err(|e| Error::Failed(format!("{}: {e}", file.display())))?;
        output_file::write(file, &page)?;
    }
    print::out(format_args!("{}", table(&answer)));
    Ok(Exit::Done)
}

fn write_round_trips(file: &Path, reading: &Reading) -> Result<(), Error> {
    let links = slipstream_trace::round_trips(&reading.log);
    for link in &links {
        let [from, to] = [link.from, link.to].map(|robot| reading.name_of(robot));
        let own = file.with_extension(format!("{from}-{to}.csv"));
        output_file::write(if links.len() == 1 { file } else { &own }, &link.csv)?;
    }
    Ok(())
}

fn read(recording: &Path) -> Result<Reading, Error> {
    let reading = slipstream_trace::read(recording)?;
    for warning in &reading.warnings {
        complain!("{warning}");
    }
    Ok(reading)
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
        let (process, name, ticks) = (&figures.process, &figures.name, figures.ticks);
        let counts = [(figures.missed, "missed"), (figures.left_out, "left out")];
        let told = counts.into_iter().filter(|(count, _)| *count > 0);
        let told: String = told
            .map(|(count, what)| format!(", {count} {what}"))
            .collect();
        row(
            &mut text,
            &format!("  {process} {name}: {ticks}{told}"),
            &figures.late,
        );
        if let Some(jitter) = figures.jitter.filter(|jitter| jitter.max_s > 0.0) {
            row(&mut text, "    jitter", &jitter);
        }
    }
    for hop in answer.against.iter().flatten() {
        change_table(&mut text, hop);
    }
    text
}

fn change_table(text: &mut String, hop: &HopChange) {
    let title = format!("{} → {}, means", hop.from, hop.to);
    let _ = writeln!(
        text,
        "\n{title:22}      here      other  difference (95 % interval, ms)"
    );
    for change in &hop.stages {
        let [here, other, difference] =
            [change.mean_s, change.other_mean_s, change.difference_s].map(|s| s * 1e3);
        let [low, high] = change.ci95_s.map(|s| s * 1e3);
        let mark = if change.changed { "changed" } else { "" };
        let stage = &change.stage;
        let line = format!(
            "  {stage:18} {here:10.4} {other:10.4} {difference:+11.4} ({low:+.4} … {high:+.4}) {mark}"
        );
        let _ = writeln!(text, "{}", line.trim_end());
    }
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

fn row(text: &mut String, what: &str, figures: &Percentiles) {
    let [p50, p99, max] = [figures.p50_s, figures.p99_s, figures.max_s].map(|s| s * 1e3);
    let _ = writeln!(text, "{what:34} {p50:10.4} {p99:10.4} {max:10.4}");
}
