//! The page of a diagnosis: what is wrong with the model and what to do, then why that, what else was
//! looked at, how good the data is, and how the page was made.

mod cards;
mod data;
mod diagnosis;
mod errors;
mod evidence;
mod findings;
mod first_screen;
mod headline;
mod markdown;
mod ready;
mod ruled_out;

use std::fmt::Write as _;

use maud::{Markup, html};
use slipstream_answer::{Figures, Verdict};

use crate::parts::{Fact, Page};

pub use diagnosis::Diagnosis;
pub use first_screen::first_screen;
pub use headline::headline;

/// Robots whose evidence is drawn; more are told in a sentence.
const DRAWN: usize = 12;
/// The HTML file.
pub fn page(diagnosis: &Diagnosis<'_>) -> String {
    let answer = diagnosis.answer;
    let mut anchors = vec![("evidence", "Evidence")];
    let has_limits = diagnosis.figures.iter().any(|own| !own.limits.is_empty());
    if has_limits {
        anchors.push(("ruled-out", "Ruled out"));
    }
    if answer
        .findings
        .iter()
        .any(|own| !own.confused_with.is_empty())
    {
        anchors.push(("alike", "Look-alikes"));
    }
    anchors.extend([("data", "Data"), ("made", "Made by")]);
    let page = Page {
        command: "diagnose",
        subject: diagnosis.subject.clone(),
        summary: diagnosis.sentence(),
        anchors,
        markdown: Some(markdown::markdown(diagnosis)),
        body: body(diagnosis),
        command_line: diagnosis.command_line.clone(),
        facts: facts(diagnosis),
        answer: serde_json::to_string(answer).ok(),
    };
    page.html()
}

/// The first screen alone, as an HTML file: what a notebook shows.
pub fn first_screen_page(diagnosis: &Diagnosis<'_>) -> String {
    let page = Page {
        command: "diagnose",
        subject: diagnosis.subject.clone(),
        summary: diagnosis.sentence(),
        body: first_screen(diagnosis),
        command_line: diagnosis.command_line.clone(),
        ..Page::default()
    };
    page.bare_html()
}

fn body(diagnosis: &Diagnosis<'_>) -> Markup {
    let mut machines: Vec<&Figures> = diagnosis.figures.iter().collect();
    // robots with findings come first
    machines.sort_by_key(|own| {
        !diagnosis
            .answer
            .findings
            .iter()
            .any(|f| f.robot == own.robot)
    });
    let left_out: Vec<&str> = machines
        .iter()
        .skip(DRAWN)
        .map(|own| own.robot.as_str())
        .collect();
    machines.truncate(DRAWN);
    html! {
        (first_screen(diagnosis))
        (evidence::section(diagnosis, &machines))
        @if !left_out.is_empty() {
            p class="sub" { "Not drawn here: " (left_out.join(", ")) ". Their findings are in the table above." }
        }
        (ruled_out::section(diagnosis, &machines))
        (ruled_out::alike(diagnosis))
        (data::section(diagnosis, &machines))
    }
}

fn facts(diagnosis: &Diagnosis<'_>) -> Vec<Fact> {
    let answer = diagnosis.answer;
    let verdict = match answer.verdict {
        Verdict::Match => "match",
        Verdict::Explained => "explained",
        Verdict::Unexplained => "unexplained",
    };
    let count = answer.findings.len();
    let horizon = answer.held_out.horizon_s;
    let mut facts: Vec<Fact> = vec![
        (
            "Verdict",
            html! { code { (verdict) } ", " (count) " finding" @if count != 1 { "s" }
            ". This page carries its answer as JSON in " code { "#answer" } "." },
        ),
        (
            "Scoring",
            html! { "Windows of " (horizon) " s. The start of each is fitted to its first 0.5 s; the rest is simulated "
            "open loop, by the commands or else by the wheels. The totals predict each window by a model fitted "
            "without it. In standard deviations of the sensors: "
            (format!("{:.2}", answer.held_out.nrmse_before)) " before, "
            (format!("{:.2}", answer.held_out.nrmse_after)) " after; noise alone gives 1. "
            "Shares of the error are means over all orders in which findings can be taken out (Shapley)." },
        ),
        (
            "Intervals",
            html! { "95 %, from the spread between blocks of time" },
        ),
    ];
    let noise: Vec<String> = answer
        .process_noise
        .iter()
        .map(|own| {
            format!(
                "{}: {} of {} {} over {} s",
                own.robot,
                own.acts_on.replace('_', " "),
                crate::parts::short(own.size),
                own.unit,
                own.correlation_time_s
            )
        })
        .collect();
    if !noise.is_empty() {
        facts.push(("Always pushes", html! { (noise.join("; ")) " (standard deviation; follows nothing that was looked at)" }));
    }
    let mut models = String::new();
    for robot in diagnosis.robots().into_iter().take(DRAWN) {
        if let Some(model) = diagnosis.model(robot) {
            let masses = if model.robot.body_mass_kg.is_some() {
                "dynamic"
            } else {
                "kinematic"
            };
            let _ = write!(
                models,
                "{robot}: {masses}, radius {} m, half track {} m. ",
                model.robot.wheel_radius_m, model.robot.half_track_m
            );
        }
    }
    facts.push(("Model", html! { (models) }));
    facts.extend(diagnosis.facts.iter().cloned());
    facts
}
