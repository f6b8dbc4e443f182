//! The page of two recordings of one experiment: where the paths, the spacing, the slip and the delays differ.

mod charts;
mod tables;

use maud::html;
use slipstream_recording::two_runs::TwoRuns;

use crate::parts::{self, Fact, Icon, Tone, command, fixed, verdict};

/// Robots that are drawn.
const DRAWN: usize = 12;
/// Distance up to which the paths count as the same, and largest difference of spacing errors that does (m).
const SAME_PATH_M: f64 = 0.02;
const SAME_SPACING_M: f64 = 0.01;

/// What the page shows.
pub struct Page<'a> {
    /// The answer.
    pub answer: &'a TwoRuns,
    /// Commands that say more.
    pub next: &'a [String],
    /// The command that made it.
    pub command_line: String,
    /// Program and files.
    pub facts: Vec<Fact>,
}

/// The HTML file.
pub fn page(page: &Page<'_>) -> String {
    let answer = page.answer;
    let is_same = is_same(answer);
    let (tone, icon, chip) = if is_same {
        (Tone::Good, Icon::Tick, "Close together")
    } else {
        (Tone::Bad, Icon::Apart, "They differ")
    };
    let [from_s, to_s] = answer.span_s;
    let robots = match &*answer.robots {
        [one] => one.robot.clone(),
        several => format!("{} robots", several.len()),
    };
    let length = fixed(to_s - from_s, 0);
    let facts = format!(
        "{robots} · {length} s in both · {} as measured, {} as simulated",
        answer.real, answer.simulated
    );
    // What differs most, then the rest.
    let (most, rest) = answer
        .headline
        .split_once("; ")
        .unwrap_or((&answer.headline, ""));
    let most = most.trim_end_matches('.').to_owned() + ".";
    let lead = html! {
        @if !rest.is_empty() { "Besides, " (rest) " " }
        "Distances are as measured: the noise of the pose sensors is in them."
    };
    let body = html! {
        (verdict(tone, icon, chip, &facts, &most, &lead))
        (charts::robots(&answer.robots, DRAWN))
        section { h2 { "Robots" } (tables::robots(&answer.robots)) }
        @if !answer.links.is_empty() { section { h2 { "Delays of the links" } (tables::links(&answer.links)) } }
        section { h2 { "What to do next" }
            @for (place, text) in page.next.iter().enumerate() { (command(&format!("next{place}"), text)) }
        }
    };
    let html = parts::Page {
        command: "compare",
        subject: format!("{} and {}", answer.real, answer.simulated),
        summary: answer.headline.clone(),
        body,
        command_line: page.command_line.clone(),
        facts: page.facts.clone(),
        answer: serde_json::to_string(answer).ok(),
        ..parts::Page::default()
    };
    html.html()
}

/// Whether no path and no spacing differs by more than is worth a look.
fn is_same(answer: &TwoRuns) -> bool {
    answer.robots.iter().all(|own| {
        let spacing_m = own
            .spacing
            .as_ref()
            .and_then(|own| own.largest_difference_m);
        own.path
            .is_none_or(|path| path.is_noise() || path.largest_m < SAME_PATH_M)
            && spacing_m.is_none_or(|m| m.abs() < SAME_SPACING_M)
    })
}
