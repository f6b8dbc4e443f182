//! What a trace says first, for page and terminal.

use maud::{Markup, html};
use slipstream_trace::{Age, Hop, LatencyAnswer, LatencyChange};

use crate::stages::{ms, stage_name};

/// Share of the latency from which on a stage is named by itself, and drawn in the bar itself.
pub(super) const LARGE: f64 = 0.02;

/// What zeros mean on the virtual clock.
pub(super) const VIRTUAL: &str = "The run was on the virtual clock: computing, transport and the wait for the plant step take no time there, by construction.";

/// Links of which a position was used.
pub(super) fn used(answer: &LatencyAnswer) -> impl Iterator<Item = &Hop> {
    answer.hops.iter().filter(|hop| hop.end_to_end.is_some())
}

/// The link whose latency is the middle one.
pub(super) fn median_hop(answer: &LatencyAnswer) -> Option<&Hop> {
    let mut hops: Vec<&Hop> = used(answer).collect();
    let end = |hop: &Hop| hop.end_to_end.map_or(0.0, |own| own.mean_s);
    hops.sort_by(|a, b| end(a).total_cmp(&end(b)));
    hops.get(hops.len() / 2).copied()
}

/// Whether the run was on the virtual clock, on which nothing computes or travels for any time.
pub fn is_virtual(answer: &LatencyAnswer) -> bool {
    let takes_no_time = |hop: &Hop| {
        let mut own = hop
            .stages
            .iter()
            .filter(|own| matches!(own.stage.as_ref(), "compute" | "transport"));
        own.all(|own| own.figures.max_s == 0.0)
    };
    used(answer).next().is_some() && used(answer).all(takes_no_time)
}

/// Where the time went, in a sentence; beside another run, what differs.
pub fn headline(answer: &LatencyAnswer) -> String {
    let Some(hop) = median_hop(answer) else {
        return "No position was used: nothing to measure.".to_owned();
    };
    let parts = parts(hop, !answer.topics.is_empty());
    let total = hop.end_to_end.map_or(0.0, |own| own.mean_s);
    let end = match answer.topics.is_empty() {
        true => "torque",
        false => "command",
    };
    let beside = beside(answer, hop).unwrap_or_default();
    format!(
        "A position takes {} ms from encoder to {end} in the mean{beside}: {}.",
        ms(total),
        parts.join(", ")
    )
}

/// The two largest stages of a link and the rest, in words.
fn parts(hop: &Hop, is_real: bool) -> Vec<String> {
    let total = hop.end_to_end.map_or(0.0, |own| own.mean_s);
    let mut stages: Vec<(&str, f64)> = hop
        .stages
        .iter()
        .map(|own| (own.stage.as_ref(), own.figures.mean_s))
        .collect();
    stages.sort_by(|a, b| b.1.total_cmp(&a.1));
    let count = stages
        .iter()
        .take(2)
        .filter(|own| own.1 > LARGE * total)
        .count();
    let rest: f64 = stages[count..].iter().map(|own| own.1).sum();
    let large = stages[..count].iter();
    let mut parts: Vec<String> = large
        .map(|(stage, s)| format!("{} ms {}", ms(*s), words(stage, is_real)))
        .collect();
    if rest > 0.0 {
        parts.push(format!("{} ms all the rest", ms(rest)));
    }
    parts
}

fn words(stage: &str, is_real: bool) -> &'static str {
    match stage {
        "injected_delay" => "is the delay you set",
        "outer_wait" => "the wait for the next outer tick",
        "inner_wait" => "the wait for the next inner tick",
        "apply_wait" if is_real => "the way to the robot's topic",
        "apply_wait" => "the wait for the plant step",
        "sample_wait" if is_real => "the way from the robot and the wait for the sender's tick",
        "sample_wait" => "the wait for the sender's tick",
        "compute" => "computing",
        _ => "the bus",
    }
}

/// How a link differs from the other run, in words: in all, and the stage that changed most.
fn beside(answer: &LatencyAnswer, hop: &Hop) -> Option<String> {
    let changes = answer.against.as_ref()?;
    let own = changes
        .iter()
        .find(|own| own.from == hop.from && own.to == hop.to)?;
    let is_all = |own: &&LatencyChange| own.stage == "end_to_end";
    let all = own.stages.iter().find(is_all)?;
    if !all.changed {
        return Some(", as long as in the other run".to_owned());
    }
    let parts = own.stages.iter().filter(|own| own.changed && !is_all(own));
    let most = parts.max_by(|a, b| a.difference_s.abs().total_cmp(&b.difference_s.abs()));
    let by = |s: f64| {
        let word = if s < 0.0 { "less" } else { "more" };
        format!("{} ms {word}", ms(s.abs()))
    };
    let most = most.map_or_else(String::new, |own| {
        format!(" ({}: {})", stage_name(&own.stage), by(own.difference_s))
    });
    Some(format!(
        ", {} than in the other run{most}",
        by(all.difference_s)
    ))
}

/// The follower whose information is oldest in the median.
fn oldest(answer: &LatencyAnswer) -> Option<&Age> {
    let followers = answer.at_outer_ticks.iter().filter(|own| own.to != "r1");
    followers.max_by(|a, b| a.figures.p50_s.total_cmp(&b.figures.p50_s))
}

/// How old the positions in use are.
pub(super) fn lead(answer: &LatencyAnswer) -> Markup {
    html! {
        @match oldest(answer) {
            Some(own) => {
                "At its outer ticks " (own.to) " steers by a position that is " b class="cw" { (ms(own.figures.p50_s)) " ms" }
                " old in the median, and " b class="cw" { (ms(own.figures.p99_s)) " ms" } " in one of a hundred."
            }
            None => "No robot steers by the position of another."
        }
    }
}

/// The same without markup, and what zeros mean.
pub fn lead_text(answer: &LatencyAnswer) -> String {
    let age = match oldest(answer) {
        Some(own) => format!(
            "At its outer ticks {} steers by a position that is {} ms old in the median, and {} ms in one of a hundred.",
            own.to,
            ms(own.figures.p50_s),
            ms(own.figures.p99_s)
        ),
        None => "No robot steers by the position of another.".to_owned(),
    };
    match is_virtual(answer) {
        true => format!("{age}\n{VIRTUAL}"),
        false => age,
    }
}
