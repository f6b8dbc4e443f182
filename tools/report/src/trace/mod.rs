//! The page of a trace: where the time went between encoder and torque, stage by stage.

mod age;
mod bars;
mod words;

use maud::{Markup, html};
use slipstream_trace::{
    Hop, Host, LatencyAnswer, Percentiles, TopicDelay, TraceReading, Uncertainty,
};

use self::bars::LINKS;
use self::words::used;
use crate::parts::{Cell, Fact, Icon, Page, Tone, fixed, table, verdict};
use crate::stages::{ms, stage_class, stage_name};

pub use self::words::{headline, is_virtual, lead_text};

/// What the page shows.
pub struct Latency<'a> {
    /// Name of the recording.
    pub subject: String,
    /// The answer.
    pub answer: &'a LatencyAnswer,
    /// What it was computed from.
    pub reading: &'a TraceReading,
    /// The command that made it.
    pub command_line: String,
    /// Program and files.
    pub facts: Vec<Fact>,
}

/// The HTML file.
pub fn page(latency: &Latency<'_>) -> String {
    let answer = latency.answer;
    let sentence = headline(answer);
    let troubles = troubles(answer);
    let (tone, icon) = if troubles.is_empty() {
        (Tone::Good, Icon::Tick)
    } else {
        (Tone::Bad, Icon::Half)
    };
    let chip = if troubles.is_empty() {
        "Nothing lost, nothing late".to_owned()
    } else {
        troubles.join(", ")
    };
    let body = html! {
        (verdict(tone, icon, &chip, &facts(answer), &sentence, &words::lead(answer)))
        (bars::bars(answer))
        section class="first" { div class="pair" {
            div { h2 { "Stage by stage" } (stages(answer)) }
            div { h2 { "Age of the position in use" } (age::ages(latency.reading)) }
        } }
        (loops(answer))
        (topics(answer))
        (hosts(answer))
        (against(answer))
    };
    let page = Page {
        command: "trace",
        subject: latency.subject.clone(),
        summary: sentence,
        body,
        command_line: latency.command_line.clone(),
        facts: latency.facts.clone(),
        answer: serde_json::to_string(answer).ok(),
        ..Page::default()
    };
    page.html()
}

/// What went wrong, in words.
fn troubles(answer: &LatencyAnswer) -> Vec<String> {
    let lost: u64 = answer.hops.iter().map(|hop| hop.incomplete.lost).sum();
    let missed: u64 = answer
        .loops
        .iter()
        .map(|own| own.missed + own.left_out)
        .sum();
    let mut words = Vec::new();
    if lost > 0 {
        words.push(format!("{lost} lost"));
    }
    if missed > 0 {
        words.push(format!(
            "{missed} deadline{} missed",
            if missed == 1 { "" } else { "s" }
        ));
    }
    words
}

fn facts(answer: &LatencyAnswer) -> String {
    let sent: u64 = answer.hops.iter().map(|hop| hop.sent).sum();
    let ticks: u64 = answer.loops.iter().map(|own| own.ticks).sum();
    let missed: u64 = answer
        .loops
        .iter()
        .map(|own| own.missed + own.left_out)
        .sum();
    format!(
        "{} links · {} positions sent · {} of {} deadlines missed",
        answer.hops.len(),
        fixed(sent as f64, 0),
        fixed(missed as f64, 0),
        fixed(ticks as f64, 0)
    )
}

fn stages(answer: &LatencyAnswer) -> Markup {
    let hops: Vec<&Hop> = used(answer).take(LINKS).collect();
    let mut heads = vec!["Stage, ms".to_owned()];
    let is_uncertain = |hop: &&Hop| hop.stages.iter().any(|own| !own.uncertainty_s.is_exact());
    let are_uncertain = hops.iter().any(is_uncertain);
    for hop in &hops {
        heads.push(format!("{} → {}: mean", hop.from, hop.to));
        heads.push("p99".to_owned());
        if are_uncertain {
            heads.push("± clocks".to_owned());
        }
    }
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let cells = |own: &Percentiles, uncertainty: Uncertainty| {
        let pair = [own.mean_s, own.p99_s].map(|value| Cell::number(value, ms(value)));
        let clocks = are_uncertain.then(|| clocks(uncertainty));
        pair.into_iter().chain(clocks)
    };
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let count = hops.first().map_or(0, |hop| hop.stages.len());
    for stage in 0..count {
        let id = hops[0].stages[stage].stage.as_ref();
        let name = html! { i class=(format!("sw {}", stage_class(id))) {} " " (stage_name(id)) };
        let mut row = vec![Cell::markup(name)];
        row.extend(
            hops.iter()
                .filter_map(|hop| hop.stages.get(stage))
                .flat_map(|own| cells(&own.figures, own.uncertainty_s)),
        );
        rows.push(row);
    }
    let mut total = vec![Cell::markup(html! { b { "Encoder to torque" } })];
    total.extend(
        hops.iter()
            .filter_map(|hop| hop.end_to_end)
            .flat_map(|own| cells(&own, Uncertainty::Exact)),
    );
    rows.push(total);
    html! {
        @if is_virtual(answer) { p class="sub" { (words::VIRTUAL) } }
        (table("Stages of each link in milliseconds", &heads, &rows))
        @if are_uncertain {
            p class="sub" { "A stage that ends on another host than it begins is uncertain by the clocks of the hosts, and may be negative. "
                "The sum of the stages is exact: both of its ends are on the plant's host." }
        }
        (fates(answer))
    }
}

/// By how much the clocks of hosts make a duration uncertain, in ms.
fn clocks(uncertainty: Uncertainty) -> Cell {
    match (uncertainty, uncertainty.seconds()) {
        (Uncertainty::Exact, _) => Cell::text(""),
        (_, Some(value)) => Cell::number(value, ms(value)),
        (_, None) => Cell::text("unknown"),
    }
}

/// What became of the messages of each link.
fn fates(answer: &LatencyAnswer) -> Markup {
    let rows: Vec<Vec<Cell>> = answer
        .hops
        .iter()
        .map(|hop| {
            let other = &hop.incomplete;
            let late = other.superseded + other.stale + other.overwritten;
            vec![
                Cell::text(format!("{} → {}", hop.from, hop.to)),
                Cell::count(hop.sent),
                Cell::count(hop.messages),
                Cell::count(other.lost),
                Cell::count(late),
                Cell::count(other.under_way),
                Cell::count(other.receiver_died + other.untold),
            ]
        })
        .collect();
    html! {
        h3 style="margin-top:20px" { "What became of the messages" }
        (table("Messages of each link", &["Link", "Sent", "Used", "Lost", "Overtaken", "Under way", "Not known"], &rows))
    }
}

fn loops(answer: &LatencyAnswer) -> Markup {
    let rows: Vec<Vec<Cell>> = answer
        .loops
        .iter()
        .map(|own| {
            let time = |value: f64| Cell::number(value, ms(value));
            let jitter = own.jitter.map_or(0.0, |jitter| jitter.p99_s);
            vec![
                Cell::text(format!("{} {}", own.process, own.name)),
                Cell::count(own.ticks),
                Cell::count(own.missed),
                Cell::count(own.left_out),
                time(own.late.p50_s),
                time(own.late.p99_s),
                time(own.late.max_s),
                time(jitter),
            ]
        })
        .collect();
    html! {
        section {
            h2 { "Deadlines" }
            p class="sub" { "How long after its due time each tick began, in ms." }
            (table("Deadlines of each loop", &["Loop", "Ticks", "Missed", "Left out", "Late p50", "p99", "Largest", "Jitter p99"], &rows))
        }
    }
}

/// How long messages of real robots were under way.
fn topics(answer: &LatencyAnswer) -> Markup {
    let row = |own: &TopicDelay| {
        let time = |value: f64| Cell::number(value, ms(value));
        vec![
            Cell::text(format!("{} {}", own.robot, own.topic)),
            Cell::count(own.messages),
            time(own.figures.p50_s),
            time(own.figures.p95_s),
            time(own.figures.p99_s),
            time(own.figures.max_s),
        ]
    };
    let rows: Vec<Vec<Cell>> = answer.topics.iter().map(row).collect();
    html! {
        @if !rows.is_empty() { section {
            h2 { "Topics of the robots" }
            p class="sub" { "How long messages were under way, in ms. What a robot tells: from its stamp, beyond its fastest message. \
                Commands: from the end of the agent's tick to the topic." }
            (table("Delay of each topic", &["Topic", "Messages", "p50", "p95", "p99", "Largest"], &rows))
        } }
    }
}

/// The clocks of the other hosts.
fn hosts(answer: &LatencyAnswer) -> Markup {
    let figure = |value: Option<f64>, text: fn(f64) -> String| {
        value.map_or_else(
            || Cell::text("unknown"),
            |value| Cell::number(value, text(value)),
        )
    };
    let row = |own: &Host| {
        vec![
            Cell::text(&own.host),
            Cell::text(own.robots.join(", ")),
            figure(own.offset_s, |s| fixed(s, 6)),
            figure(own.drift_ppm, |ppm| fixed(ppm, 3)),
            figure(own.bound_s, ms),
            figure(own.error_s, ms),
            figure(own.round_trip_s, ms),
            Cell::count(own.windows),
        ]
    };
    let rows: Vec<Vec<Cell>> = answer.hosts.iter().map(row).collect();
    let heads = [
        "Host",
        "Robots",
        "Offset, s",
        "Drift, ppm",
        "Bound, ms",
        "Error, ms",
        "Round trip, ms",
        "Estimates",
    ];
    html! {
        @if !rows.is_empty() {
            section {
                h2 { "Clocks of the other hosts" }
                p class="sub" { "Against the clock of the plant's host: the last estimate of offset and drift, the largest bound of the offset, the largest error of a time stamp and the shortest round trip." }
                (table("Clocks of the other hosts", &heads, &rows))
            }
        }
    }
}

fn against(answer: &LatencyAnswer) -> Markup {
    let Some(changes) = &answer.against else {
        return html! {};
    };
    let rows: Vec<Vec<Cell>> = changes
        .iter()
        .flat_map(|hop| {
            hop.stages.iter().map(move |own| {
                let mut row = vec![
                    Cell::text(format!("{} → {}", hop.from, hop.to)),
                    Cell::text(stage_name(&own.stage)),
                ];
                row.extend(
                    [own.mean_s, own.other_mean_s, own.difference_s]
                        .map(|value| Cell::number(value, ms(value))),
                );
                row.push(Cell::text(own.ci95_s.map_or_else(
                    || "unknown".to_owned(),
                    |[low, high]| format!("{} to {}", ms(low), ms(high)),
                )));
                row
            })
        })
        .collect();
    html! {
        section {
            h2 { "Beside the other run" }
            p class="sub" { "Means in ms, the difference with its 95 % interval." }
            (table("Change of each stage", &["Link", "Stage", "Here", "Other", "Difference", "95 %"], &rows))
        }
    }
}
