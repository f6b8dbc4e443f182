//! The page of a comparison: how far the simulation drifts from the recording, when, and along which path.

mod apart;
mod charts;

use maud::html;
use slipstream_recording::Channel;
use slipstream_recording::recording::Recording;

use self::apart::Apart;
use crate::parts::{Fact, Icon, Page, Tone, columns_of, fixed, short, verdict};

/// Robots that are drawn.
const DRAWN: usize = 12;
/// Distance from which on the simulation counts as drifting apart (cm), and that which is named first.
const APART_CM: f64 = 2.0;
const NAMED_CM: f64 = 10.0;

/// What the page shows.
pub struct Comparison<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Its channels beside the simulation.
    pub channels: &'a [Channel],
    /// The command that made it.
    pub command_line: String,
    /// Program and files.
    pub facts: Vec<Fact>,
}

/// The HTML file.
pub fn page(comparison: &Comparison<'_>) -> String {
    let recording = comparison.recording;
    let mut robots: Vec<&str> = Vec::new();
    for channel in comparison.channels {
        if !robots.contains(&channel.robot.as_str()) {
            robots.push(&channel.robot);
        }
    }
    let mut apart: Vec<Apart<'_>> = robots
        .iter()
        .map(|robot| Apart::new(robot, comparison.channels))
        .collect();
    let most = |own: &Apart<'_>| Apart::largest(&own.distance).map_or(0.0, |p| p.1);
    apart.sort_by(|a, b| most(b).total_cmp(&most(a)));
    let left_out = apart.len().saturating_sub(DRAWN);
    apart.truncate(DRAWN);
    let lines: usize = comparison
        .channels
        .iter()
        .filter(|own| apart.iter().any(|a| a.robot == own.robot))
        .count();
    let columns = columns_of(2 * lines + 2 * apart.len());
    let (answer, lead, tone) = words(recording, &apart);
    let chip = if tone == Tone::Good {
        (Icon::Tick, "Close together")
    } else {
        (Icon::Apart, "Drifts apart")
    };
    let span_s = comparison
        .channels
        .iter()
        .flat_map(|own| own.recorded.last())
        .map(|p| p.0);
    let first_s = comparison
        .channels
        .iter()
        .flat_map(|own| own.recorded.first())
        .map(|p| p.0);
    let length = span_s.fold(f64::NEG_INFINITY, f64::max) - first_s.fold(f64::INFINITY, f64::min);
    let facts = format!(
        "{} · {} s · model as given, nothing fitted but the start",
        if robots.len() == 1 {
            robots[0].to_owned()
        } else {
            format!("{} robots", robots.len())
        },
        fixed(length, 0)
    );
    let body = html! {
        (verdict(tone, chip.0, chip.1, &facts, &answer, &html! { (lead) }))
        @for (place, own) in apart.iter().enumerate() {
            section class=(if place == 0 { "first" } else { "" }) {
                @if apart.len() > 1 { h2 { (own.robot) } }
                (charts::robot(comparison.channels, own, place, columns))
            }
        }
        @if left_out > 0 { p class="sub" { (left_out) " more robots are closer and are not drawn." } }
    };
    let page = Page {
        command: "compare",
        subject: recording.name.clone(),
        summary: answer,
        body,
        command_line: comparison.command_line.clone(),
        facts: comparison.facts.clone(),
        ..Page::default()
    };
    page.html()
}

fn words(recording: &Recording, apart: &[Apart<'_>]) -> (String, String, Tone) {
    let Some(worst) = apart.first() else {
        return ("Nothing to compare.".to_owned(), String::new(), Tone::Bad);
    };
    let commanded = recording
        .robot(worst.robot)
        .is_some_and(|own| own.command.is_some());
    let driven = if commanded {
        "its recorded commands"
    } else {
        "its own wheels"
    };
    let who = if apart.len() == 1 {
        "robot".to_owned()
    } else {
        worst.robot.to_owned()
    };
    let Some((at_s, distance)) = Apart::largest(&worst.distance) else {
        return (
            format!(
                "Driven by {driven}, the simulated {who} is compared by its wheels: there are no poses."
            ),
            "slipstream diagnose says what the model leaves out.".to_owned(),
            Tone::Bad,
        );
    };
    let turn = Apart::largest(&worst.heading).map_or(String::new(), |p| {
        format!(" and {}°", fixed(p.1.abs(), usize::from(p.1.abs() < 10.0)))
    });
    if distance < APART_CM {
        return (
            format!(
                "Driven by {driven}, the simulated {who} stays within {} cm{turn} of the recorded one.",
                short(distance)
            ),
            "What small effects could still be hidden, slipstream diagnose says.".to_owned(),
            Tone::Good,
        );
    }
    let first = worst.distance.iter().find(|p| p.1 > NAMED_CM);
    let begin = worst.distance.first().map_or(0.0, |p| p.0);
    let lead = first.map_or_else(
        || format!("Furthest apart after {} s. slipstream diagnose says why.", fixed(at_s - begin, 0)),
        |(t, _)| {
            format!(
                "{NAMED_CM} cm apart after {} s, furthest after {} s. slipstream diagnose says why.",
                fixed(t - begin, 0),
                fixed(at_s - begin, 0)
            )
        },
    );
    (
        format!(
            "Driven by {driven}, the simulated {who} drifts up to {} cm{turn} from the recorded one.",
            short(distance)
        ),
        lead,
        Tone::Bad,
    )
}
