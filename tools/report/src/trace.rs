//! The page of a trace: where the time went between encoder and torque, stage by stage.

use maud::{Markup, html};
use slipstream_trace::{
    Answer, Hop, Host, Percentiles, Reading, TopicDelay, Uncertainty, ages_over_time,
};

use crate::parts::{
    Cell, Fact, Frame, Icon, Ink, Page, Row, Rows, Scale, Tone, fixed, table, verdict,
};
use crate::stages::{ms, stage_class, stage_name};

/// Links that are drawn, and rows of age.
const LINKS: usize = 8;
const AGES: usize = 4;
/// Share of the longest latency from which on a stage is drawn in the bar itself.
const LARGE: f64 = 0.02;

/// What the page shows.
pub struct Latency<'a> {
    /// Name of the recording.
    pub subject: String,
    /// The answer.
    pub answer: &'a Answer,
    /// What it was computed from.
    pub reading: &'a Reading,
    /// The command that made it.
    pub command_line: String,
    /// Program and files.
    pub facts: Vec<Fact>,
}

/// The HTML file.
pub fn page(latency: &Latency<'_>) -> String {
    let answer = latency.answer;
    let hop = median_hop(answer);
    let sentence = hop.map_or_else(
        || "No position was used: nothing to measure.".to_owned(),
        |hop| sentence(hop, !answer.topics.is_empty()),
    );
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
        (verdict(tone, icon, &chip, &facts(answer), &sentence, &lead(answer)))
        (bars(answer))
        section class="first" { div class="pair" {
            div { h2 { "Stage by stage" } (stages(answer)) }
            div { h2 { "Age of the position in use" } (ages(latency)) }
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

/// Links of which a position was used.
fn used(answer: &Answer) -> impl Iterator<Item = &Hop> {
    answer.hops.iter().filter(|hop| hop.end_to_end.is_some())
}

/// The link with the median latency.
fn median_hop(answer: &Answer) -> Option<&Hop> {
    let mut hops: Vec<&Hop> = used(answer).collect();
    let end = |hop: &Hop| hop.end_to_end.map_or(0.0, |own| own.p50_s);
    hops.sort_by(|a, b| end(a).total_cmp(&end(b)));
    hops.get(hops.len() / 2).copied()
}

fn sentence(hop: &Hop, is_real: bool) -> String {
    let total = hop.end_to_end.map_or(0.0, |own| own.p50_s);
    let mut stages: Vec<(&str, f64)> = hop
        .stages
        .iter()
        .map(|own| (own.stage.as_ref(), own.figures.p50_s))
        .collect();
    stages.sort_by(|a, b| b.1.total_cmp(&a.1));
    let large: Vec<&(&str, f64)> = stages
        .iter()
        .take(2)
        .filter(|own| own.1 > LARGE * total)
        .collect();
    let rest = total - large.iter().map(|own| own.1).sum::<f64>();
    let words = |stage: &str| match stage {
        "injected_delay" => "is the delay you set",
        "outer_wait" => "the wait for the next outer tick",
        "inner_wait" => "the wait for the next inner tick",
        "apply_wait" if is_real => "the way to the robot's topic",
        "apply_wait" => "the wait for the plant step",
        "sample_wait" if is_real => "the way from the robot and the wait for the sender's tick",
        "sample_wait" => "the wait for the sender's tick",
        "compute" => "computing",
        _ => "the bus",
    };
    let mut parts: Vec<String> = large
        .iter()
        .map(|(stage, s)| format!("{} ms {}", ms(*s), words(stage)))
        .collect();
    if rest > 0.0 {
        parts.push(format!("{} ms all the rest", ms(rest)));
    }
    format!(
        "A position takes {} ms from encoder to {}: {}.",
        ms(total),
        if is_real { "command" } else { "torque" },
        parts.join(", ")
    )
}

/// What went wrong, in words.
fn troubles(answer: &Answer) -> Vec<String> {
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

fn facts(answer: &Answer) -> String {
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

fn lead(answer: &Answer) -> Markup {
    let mut ages: Vec<_> = answer
        .at_outer_ticks
        .iter()
        .filter(|own| own.to != "r1")
        .collect();
    ages.sort_by(|a, b| b.figures.p50_s.total_cmp(&a.figures.p50_s));
    html! {
        @match ages.first() {
            Some(own) => {
                "At its outer ticks " (own.to) " steers by a position that is " b class="cw" { (ms(own.figures.p50_s)) " ms" }
                " old in the median, and " b class="cw" { (ms(own.figures.p99_s)) " ms" } " in one of a hundred."
            }
            None => "No robot steers by the position of another."
        }
    }
}

fn bars(answer: &Answer) -> Markup {
    let hops: Vec<&Hop> = used(answer).take(LINKS).collect();
    let end = |hop: &Hop| hop.end_to_end.map_or(0.0, |own| own.p99_s.max(own.p50_s));
    let longest = hops.iter().map(|hop| end(hop)).fold(0.0, f64::max);
    let scale = Scale::new(0.0, 1000.0 * longest.max(1e-9), 5);
    let at = |seconds: f64| 100.0 * scale.place(1000.0 * seconds);
    let left = used(answer).count() - hops.len();
    html! {
        @if !hops.is_empty() {
            figure class="hops" aria-label="Median latency of each link, stage by stage" {
                @for hop in &hops {
                    div class="hop" {
                        b { (hop.from) " → " (hop.to) }
                        div class="bar" role="img" aria-label=(described(hop)) style="gap:0;position:relative" {
                            @for stage in &hop.stages {
                                span class=(stage_class(&stage.stage)) style=(format!("width:{:.2}%;min-width:0", at(stage.figures.p50_s).max(0.0)))
                                    title=(format!("{}: {} ms", stage_name(&stage.stage), ms(stage.figures.p50_s))) {}
                            }
                            @if let Some(all) = hop.end_to_end {
                                i class="whisker" style=(format!("left:{:.2}%;width:{:.2}%", at(all.p50_s), (at(all.p99_s) - at(all.p50_s)).max(0.0))) {}
                            }
                        }
                    }
                }
                div class="hop" { span {} div class="ax" style="height:18px" {
                    @for (value, text) in scale.ticks() { span style=(format!("left:{:.1}%", 100.0 * scale.place(value))) { (text) } }
                } }
                figcaption { "Medians in ms; the line goes to the 99th percentile. "
                    span class="sw sn" {} " set by you  " span class="sw sw-w" {} " waiting  " span class="sw sw-i" {} " computing and transport"
                    @if left > 0 { ". " (left) " more links are in the table." }
                }
                @if let Some(hop) = median_hop(answer) { (rest(hop)) }
            }
        }
    }
}

fn described(hop: &Hop) -> String {
    let parts: Vec<String> = hop
        .stages
        .iter()
        .map(|own| format!("{} {} ms", stage_name(&own.stage), ms(own.figures.p50_s)))
        .collect();
    parts.join(", ")
}

/// The stages that are too short to be seen in the bars, enlarged.
fn rest(hop: &Hop) -> Markup {
    let total = hop.end_to_end.map_or(0.0, |own| own.p50_s);
    let small: Vec<_> = hop
        .stages
        .iter()
        .filter(|own| own.figures.p50_s > 0.0 && own.figures.p50_s < LARGE * total)
        .collect();
    let sum: f64 = small.iter().map(|own| own.figures.p50_s).sum();
    html! {
        @if sum > 0.0 {
            div class="hop" style="margin-top:10px" {
                span { b { "All the rest" } br; span class="muted" { (ms(sum)) " ms" } }
                div {
                    div class="bar" role="img" aria-label=(described(hop)) {
                        @for own in &small {
                            span class=(stage_class(&own.stage)) style=(format!("flex:{:.5};min-width:1px", own.figures.p50_s / sum)) {}
                        }
                    }
                    ul class="labs" {
                        @for own in &small {
                            li { i class=(format!("sw {}", stage_class(&own.stage))) {} span { (stage_name(&own.stage)) " " b { (ms(own.figures.p50_s)) } } }
                        }
                    }
                }
            }
        }
    }
}

fn stages(answer: &Answer) -> Markup {
    let hops: Vec<&Hop> = used(answer).take(LINKS).collect();
    let mut heads = vec!["Stage, ms".to_owned()];
    let is_uncertain = |hop: &&Hop| hop.stages.iter().any(|own| !own.uncertainty_s.is_exact());
    let are_uncertain = hops.iter().any(is_uncertain);
    for hop in &hops {
        heads.push(format!("{} → {}: p50", hop.from, hop.to));
        heads.push("p99".to_owned());
        if are_uncertain {
            heads.push("± clocks".to_owned());
        }
    }
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let cells = |own: &Percentiles, uncertainty: Uncertainty| {
        let pair = [own.p50_s, own.p99_s].map(|value| Cell::number(value, ms(value)));
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
fn fates(answer: &Answer) -> Markup {
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

fn ages(latency: &Latency<'_>) -> Markup {
    let all = ages_over_time(&latency.reading.log);
    let followers: Vec<_> = all
        .iter()
        .filter(|own| own.to != 0 && own.points.len() > 1)
        .take(AGES)
        .collect();
    let [low, high] =
        followers
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], own| {
                let first = own.points.first().map_or(low, |p| p.0);
                let last = own.points.last().map_or(high, |p| p.0);
                [low.min(first), high.max(last)]
            });
    let most = followers
        .iter()
        .flat_map(|own| own.points.iter().map(|p| 1000.0 * p.1));
    let y = Scale::around(most, true, 4);
    let x = Scale::new(low, high, 4);
    let mut rows = Rows::new("age");
    for (index, own) in followers.iter().enumerate() {
        let points: Vec<(f64, f64)> = own
            .points
            .iter()
            .map(|(t, age)| (*t, 1000.0 * age))
            .collect();
        let mut frame = Frame::new(
            x,
            y,
            110,
            format!(
                "Age of the position that {} uses, ms",
                latency.reading.name_of(own.to)
            ),
        )
        .line(Ink::Wait, &steps(&points), f64::INFINITY);
        if index + 1 == followers.len() {
            frame = frame.x_axis("s");
        }
        rows = rows.row(
            Row::new(
                format!(
                    "{} of {}",
                    latency.reading.name_of(own.to),
                    latency.reading.name_of(own.from)
                ),
                "ms",
                frame,
            )
            .reads(Ink::Wait, "ms old", &points, 1),
        );
    }
    html! {
        @if rows.is_empty() { p class="sub" { "No robot uses the position of another." } } @else {
            p class="sub" { "At each outer tick, since the encoders of the robot ahead were read. Each robot hears once in a round of the ring; "
                code { "--set links.protocol=periodic" } " sends at each outer tick instead." }
            (rows.markup())
        }
    }
}

/// A line that holds its value until the next point.
fn steps(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut out = Vec::with_capacity(2 * points.len());
    for pair in points.windows(2) {
        out.push(pair[0]);
        out.push((pair[1].0, pair[0].1));
    }
    out.extend(points.last());
    out
}

fn loops(answer: &Answer) -> Markup {
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
fn topics(answer: &Answer) -> Markup {
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
fn hosts(answer: &Answer) -> Markup {
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

fn against(answer: &Answer) -> Markup {
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
