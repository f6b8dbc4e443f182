//! Tables of the latency for the terminal.

use std::fmt::Write as _;

use slipstream_trace::{Age, Answer, Hop, HopChange, Incomplete, Percentiles};

/// The tables of an answer. Writing to a string cannot fail.
pub(super) fn table(answer: &Answer) -> String {
    let mut text = String::new();
    for hop in &answer.hops {
        hop_table(&mut text, hop);
    }
    let ages = [
        ("Age of the positions behind a torque", &answer.platoon),
        (
            "Age of the positions at outer ticks",
            &answer.at_outer_ticks,
        ),
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
        "Delay of ticks                          p50        p99        max (ms)"
    );
    for figures in &answer.loops {
        let (process, name, ticks) = (&figures.process, &figures.name, figures.ticks);
        let counts = [(figures.missed, "missed"), (figures.left_out, "skipped")];
        let nonzero = counts.into_iter().filter(|(count, _)| *count > 0);
        let counts: String = nonzero
            .map(|(count, what)| format!(", {count} {what}"))
            .collect();
        row(
            &mut text,
            &format!("  {process} {name}: {ticks}{counts}"),
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
        let interval = change.ci95_s.map(|ends| ends.map(|s| s * 1e3));
        let interval = interval.map_or_else(
            || "(error of a clock unknown)".to_owned(),
            |[low, high]| format!("({low:+.4} … {high:+.4})"),
        );
        let mark = if change.changed { "changed" } else { "" };
        let stage = &change.stage;
        let line =
            format!("  {stage:18} {here:10.4} {other:10.4} {difference:+11.4} {interval} {mark}");
        let _ = writeln!(text, "{}", line.trim_end());
    }
}

fn hop_table(text: &mut String, hop: &Hop) {
    let (from, to) = (&hop.from, &hop.to);
    let (sent, used) = (hop.sent, hop.messages);
    let _ = writeln!(
        text,
        "{from} → {to}: {sent} sent, {used} used{}",
        unused(&hop.incomplete)
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

/// Counts of the messages that were not used.
pub(super) fn unused(incomplete: &Incomplete) -> String {
    let counts = [
        (incomplete.lost, "lost"),
        (incomplete.superseded, "superseded"),
        (incomplete.stale, "stale"),
        (incomplete.overwritten, "overwritten"),
        (incomplete.under_way, "in flight at the end"),
        (incomplete.receiver_died, "whose receiver died"),
        (incomplete.untold, "with missing records"),
    ];
    let nonzero = counts.into_iter().filter(|(count, _)| *count > 0);
    nonzero
        .map(|(count, what)| format!(", {count} {what}"))
        .collect()
}

fn row(text: &mut String, what: &str, figures: &Percentiles) {
    let [p50, p99, max] = [figures.p50_s, figures.p99_s, figures.max_s].map(|s| s * 1e3);
    let _ = writeln!(text, "{what:34} {p50:10.4} {p99:10.4} {max:10.4}");
}
