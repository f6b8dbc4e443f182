//! The stages of each link as bars to one scale, and what is too short for it.

use maud::{Markup, html};
use slipstream_trace::{Hop, LatencyAnswer};

use super::words::{LARGE, median_hop, used};
use crate::parts::{Scale, fixed};
use crate::stages::{ms, stage_class, stage_name};

/// Links that are drawn.
pub(super) const LINKS: usize = 8;
/// Width of a stage from which on its name stands above it (% of the bar).
const NAMED_PERCENT: f64 = 18.0;

pub(super) fn bars(answer: &LatencyAnswer) -> Markup {
    let hops: Vec<&Hop> = used(answer).take(LINKS).collect();
    let end = |hop: &Hop| hop.end_to_end.map_or(0.0, |own| own.p99_s.max(own.mean_s));
    let longest = hops.iter().map(|hop| end(hop)).fold(0.0, f64::max);
    let scale = Scale::new(0.0, 1000.0 * longest.max(1e-9), 5);
    let at = |seconds: f64| 100.0 * scale.place(1000.0 * seconds);
    let left = used(answer).count() - hops.len();
    html! {
        @if !hops.is_empty() {
            figure class="hops" aria-label="Mean latency of each link, stage by stage" {
                @if let Some(first) = hops.first() { (labels(first, &at)) }
                @for hop in &hops {
                    div class="hop" {
                        b { (hop.from) " → " (hop.to) }
                        div class="bar" role="img" aria-label=(described(hop)) style="gap:0;position:relative" {
                            @for stage in &hop.stages {
                                span class=(stage_class(&stage.stage)) style=(format!("width:{:.2}%;min-width:0", at(stage.figures.mean_s).max(0.0)))
                                    title=(format!("{}: {} ms", stage_name(&stage.stage), ms(stage.figures.mean_s))) {}
                            }
                            @if let Some(all) = hop.end_to_end {
                                i class="whisker" style=(format!("left:{:.2}%;width:{:.2}%", at(all.mean_s), (at(all.p99_s) - at(all.mean_s)).max(0.0))) {}
                            }
                        }
                    }
                }
                div class="hop" { span {} div class="ax" style="height:18px" {
                    @for (value, text) in scale.ticks() { span style=(format!("left:{:.1}%", 100.0 * scale.place(value))) { (text) } }
                } }
                figcaption { "Means in ms, which add up; the line goes to the 99th percentile. "
                    span class="sw sn" {} " set by you  " span class="sw sw-w" {} " waiting  " span class="sw sw-i" {} " computing and transport"
                    @if left > 0 { ". " (left) " more links are in the table." }
                }
                @if let Some(hop) = median_hop(answer) { (rest(hop, longest)) }
            }
        }
    }
}

fn described(hop: &Hop) -> String {
    let parts: Vec<String> = hop
        .stages
        .iter()
        .map(|own| format!("{} {} ms", stage_name(&own.stage), ms(own.figures.mean_s)))
        .collect();
    parts.join(", ")
}

/// Names above the first bar, over the stages that are wide enough.
fn labels(hop: &Hop, at: &dyn Fn(f64) -> f64) -> Markup {
    let mut begin_s = 0.0;
    let mut named: Vec<(f64, String)> = Vec::new();
    for own in &hop.stages {
        let width = at(own.figures.mean_s);
        if width > NAMED_PERCENT {
            let text = format!("{} {}", stage_name(&own.stage), ms(own.figures.mean_s));
            named.push((at(begin_s), text));
        }
        begin_s += own.figures.mean_s.max(0.0);
    }
    html! {
        @if !named.is_empty() {
            div class="hop opt" { span {} div class="ax left" style="height:18px" {
                @for (left, text) in &named { span style=(format!("left:{left:.2}%")) { (text) } }
            } }
        }
    }
}

/// The stages that are too short to be seen in the bars, enlarged.
fn rest(hop: &Hop, longest_s: f64) -> Markup {
    let total = hop.end_to_end.map_or(0.0, |own| own.mean_s);
    let small: Vec<_> = hop
        .stages
        .iter()
        .filter(|own| own.figures.mean_s > 0.0 && own.figures.mean_s < LARGE * total)
        .collect();
    let sum: f64 = small.iter().map(|own| own.figures.mean_s).sum();
    html! {
        @if sum > 0.0 {
            div class="hop" style="margin-top:10px" {
                span { b { "All the rest" } br; span class="muted" { (ms(sum)) " ms" } }
                div {
                    div class="bar thin" role="img" aria-label=(described(hop)) {
                        @for own in &small {
                            span class=(stage_class(&own.stage)) style=(format!("flex:{:.5};min-width:1px", own.figures.mean_s / sum)) {}
                        }
                    }
                    p class="small muted" { "of " (hop.from) " → " (hop.to) ", enlarged " (fixed(longest_s / sum, 0)) " times" }
                    ul class="labs" {
                        @for own in &small {
                            li { i class=(format!("sw {}", stage_class(&own.stage))) {} span { (stage_name(&own.stage)) " " b { (ms(own.figures.mean_s)) } } }
                        }
                    }
                }
            }
        }
    }
}
