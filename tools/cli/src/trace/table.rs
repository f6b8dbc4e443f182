//! Tables of the latency for the terminal.

use std::fmt::Write as _;

use slipstream_bus::time::s_from_ns;
use slipstream_trace::{
    Age, Hop, HopChange, Host, Incomplete, LatencyAnswer, Percentiles, TopicDelay, Uncertainty,
};

/// The tables of an answer. Writing to a string cannot fail.
pub(super) fn table(answer: &LatencyAnswer) -> String {
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
        head(&mut text, title, ages.iter().map(|age| age.uncertainty_s));
        for age in ages {
            let Age { from, to, .. } = age;
            let what = format!("  {from}, used by {to}");
            uncertain_row(&mut text, &what, &age.figures, age.uncertainty_s);
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
    topics_table(&mut text, &answer.topics);
    hosts_table(&mut text, &answer.hosts);
    for hop in answer.against.iter().flatten() {
        change_table(&mut text, hop);
    }
    text
}

/// How long messages of real robots were under way.
fn topics_table(text: &mut String, topics: &[TopicDelay]) {
    if topics.is_empty() {
        return;
    }
    let title = "\nTopics of the robots";
    let _ = writeln!(text, "{title:35}      p50        p99        max (ms)");
    for own in topics {
        let TopicDelay {
            robot,
            topic,
            messages,
            figures,
        } = own;
        row(text, &format!("  {robot} {topic}: {messages}"), figures);
    }
    let _ = writeln!(
        text,
        "  What a robot tells: from its stamp, beyond its fastest message. Commands: from the agent's tick to the topic."
    );
}

/// What is known of the clocks of the other hosts.
fn hosts_table(text: &mut String, hosts: &[Host]) {
    if hosts.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "\nClocks of the other hosts, against that of the plant's host
  {:10} {:>17} {:>13} {:>12} {:>12} {:>17} {:>10}  robots",
        "host",
        "offset (s)",
        "drift (ppm)",
        "bound (ms)",
        "error (ms)",
        "round trip (ms)",
        "estimates"
    );
    for host in hosts {
        let figure = |value: Option<f64>, factor: f64, decimals: usize| {
            value.map_or_else(
                || "unknown".to_owned(),
                |value| format!("{:.decimals$}", value * factor),
            )
        };
        let (name, windows) = (&host.host, host.windows);
        let offset = figure(host.offset_s, 1.0, 7);
        let drift = figure(host.drift_ppm, 1.0, 3);
        let [bound, error, round_trip] =
            [host.bound_s, host.error_s, host.round_trip_s].map(|s| figure(s, 1e3, 4));
        let robots = host.robots.join(", ");
        let line = format!(
            "  {name:10} {offset:>17} {drift:>13} {bound:>12} {error:>12} {round_trip:>17} {windows:>10}  {robots}"
        );
        let _ = writeln!(text, "{}", line.trim_end());
    }
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
        head(text, "", hop.stages.iter().map(|stage| stage.uncertainty_s));
        for stage in &hop.stages {
            let what = format!("  {}", stage.stage);
            uncertain_row(text, &what, &stage.figures, stage.uncertainty_s);
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

/// Heads of the columns of rows with these uncertainties.
fn head(text: &mut String, title: &str, rows: impl IntoIterator<Item = Uncertainty>) {
    let is_exact = rows.into_iter().all(|row| row.is_exact());
    let clocks = if is_exact {
        ""
    } else {
        "  ± of p50, by the clocks (ms)"
    };
    let _ = writeln!(
        text,
        "{title:34}      p50        p99        max (ms){clocks}"
    );
}

fn row(text: &mut String, what: &str, figures: &Percentiles) {
    uncertain_row(text, what, figures, Uncertainty::Exact);
}

/// A row, with what the clocks that measured it leave open of the median.
fn uncertain_row(text: &mut String, what: &str, figures: &Percentiles, uncertainty: Uncertainty) {
    let [p50, p99, max] = [figures.p50_s, figures.p99_s, figures.max_s].map(|s| s * 1e3);
    let clocks = match uncertainty {
        Uncertainty::Exact => String::new(),
        Uncertainty::Unknown => "       ± unknown".to_owned(),
        Uncertainty::Within(ns) => {
            let ms = s_from_ns(ns) * 1e3;
            let words = if ms >= p50.abs() {
                " (less than the clocks tell apart)"
            } else {
                ""
            };
            format!("       ± {ms:.4}{words}")
        }
    };
    let [p50, p99, max] = [p50, p99, max].map(three_digits);
    let _ = writeln!(text, "{what:34} {p50:>10} {p99:>10} {max:>10}{clocks}");
}

/// A number with the three digits that count.
fn three_digits(value: f64) -> String {
    let digits = match value.abs() {
        own if own < 5e-5 => return "0".to_owned(),
        own => 2 - own.log10().floor() as i32,
    };
    let digits = usize::try_from(digits.clamp(0, 4)).unwrap_or(0);
    format!("{value:.digits$}")
}
