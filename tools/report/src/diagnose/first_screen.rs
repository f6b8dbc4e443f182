//! The first screen of a diagnosis: verdict, error budget, path before and after, findings and what to do.

use maud::{Markup, html};
use slipstream_answer::{Answer, Budget, Finding, Paths, Verdict};

use super::diagnosis::Diagnosis;
use super::errors::{Error, errors, unexplained};
use super::findings::findings;
use super::ready::ready;
use crate::effect_words::name;
use crate::parts::{
    BudgetRow, Frame, Icon, Ink, Part, PartKind, Tone, budget, capital, fixed, floor_scales, short,
    shown_unit, verdict, with_unit,
};

/// Robots with an error budget of their own.
const BUDGETS: usize = 6;
/// Warnings that are spelled out.
const WARNINGS: usize = 4;

/// The first screen.
pub fn first_screen(diagnosis: &Diagnosis<'_>) -> Markup {
    let answer = diagnosis.answer;
    let paths = || {
        let all = diagnosis.figures.iter();
        all.flat_map(|own| own.paths.iter().map(|path| (own.robot.as_str(), path)))
    };
    let path = paths()
        .find(|(_, own)| !own.after.is_empty())
        .or_else(|| paths().next());
    let (tone, icon, chip) = chip(answer);
    html! {
        (verdict(tone, icon, chip, &kick(diagnosis), &diagnosis.sentence(), &lead(answer)))
        (budget(&budgets(diagnosis)))
        @if let Some((robot, path)) = path {
            div class="both" { (path_figure(path, (diagnosis.figures.len() > 1).then_some(robot))) div { (findings(diagnosis)) (ready(diagnosis)) } }
        } @else {
            div class="both one" { div { (findings(diagnosis)) (ready(diagnosis)) } }
        }
        (warnings(answer))
    }
}

/// How the verdict looks.
pub(super) fn chip(answer: &Answer) -> (Tone, Icon, &'static str) {
    let known = answer.findings.iter().any(|own| own.effect != "unknown");
    let compares = !answer.against.is_empty();
    match (answer.verdict, known) {
        (Verdict::Match, _) if compares => (Tone::Good, Icon::Tick, "Nothing changed"),
        (Verdict::Explained, _) if compares => (Tone::Good, Icon::Full, "Changed"),
        (Verdict::Match, _) => (Tone::Good, Icon::Tick, "The model matches"),
        (Verdict::Explained, _) => (Tone::Good, Icon::Full, "Explained"),
        (Verdict::Unexplained, true) => (Tone::Part, Icon::Half, "Partly explained"),
        (Verdict::Unexplained, false) => (Tone::Part, Icon::Ring, "Not explained"),
    }
}

/// The facts of the recordings beside the verdict.
fn kick(diagnosis: &Diagnosis<'_>) -> String {
    let robots = diagnosis.robots();
    let mut words = match robots.as_slice() {
        [one] => vec![(*one).to_owned()],
        several => vec![format!("{} robots", several.len())],
    };
    let runs = diagnosis.recordings.len();
    if runs > 1 {
        words.push(format!("{runs} recordings"));
    }
    let spans = diagnosis
        .figures
        .first()
        .map_or(&[][..], |own| &own.spans_s);
    let total_s: f64 = spans.iter().map(|[from, to]| to - from).sum();
    if total_s > 0.0 {
        words.push(format!("{} s", fixed(total_s, usize::from(total_s < 10.0))));
    }
    let all = || diagnosis.recordings.iter().flat_map(|own| &own.robots);
    let count = |of: &dyn Fn(&slipstream_recording::recording::Robot) -> Option<usize>| -> usize {
        all().filter_map(of).sum()
    };
    let streams = [
        (
            count(&|own| own.pose.as_ref().map(|s| s.t_s.len())),
            "poses",
        ),
        (
            count(&|own| own.wheels.as_ref().map(|s| s.t_s.len())),
            "wheel readings",
        ),
        (
            count(&|own| own.command.as_ref().map(|s| s.t_s.len())),
            "commands",
        ),
        (
            count(&|own| own.imu.as_ref().map(|s| s.t_s.len())),
            "IMU readings",
        ),
    ];
    words.extend(
        streams
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{} {what}", fixed(count as f64, 0))),
    );
    if streams[2].0 == 0 {
        words.push("no commands".to_owned());
    }
    words.join(" · ")
}

fn lead(answer: &Answer) -> Markup {
    let errors = errors(answer);
    let horizon = fixed(answer.held_out.horizon_s, 0);
    let left: Vec<String> = unexplained(answer)
        .iter()
        .map(|(value, unit)| with_unit(&short(*value), unit))
        .collect();
    let text = |own: &Error, end: usize| with_unit(&short(own.ends[end]), own.unit);
    let named = answer.findings.iter().any(|own| own.effect != "unknown");
    html! {
        @if answer.verdict == Verdict::Unexplained && named { (answer.statement) ". " }
        @if errors.is_empty() {
            "In standard deviations of its sensors, a prediction over " (horizon) " s is off by "
            b class="ca" { (short(answer.held_out.nrmse_after)) } " instead of "
            b class="cb" { (short(answer.held_out.nrmse_before)) } "; noise alone gives 1."
        } @else if named {
            "With " @if answer.findings.len() == 1 { "this" } @else { "these" } " corrected, a prediction over "
            (horizon) " s misses by "
            @for (place, own) in errors.iter().enumerate() {
                @if place > 0 { ", and by " }
                b class="ca" { (text(own, 1)) } " instead of " b class="cb" { (text(own, 0)) } (own.whose())
            }
            "."
            @if !left.is_empty() {
                " Of what remains, " b class="cd" { (left.join(" and ")) }
                @if left.len() > 1 { " follow" } @else { " follows" } " nothing that was looked at."
            }
        } @else {
            "A prediction over " (horizon) " s misses by "
            @for (place, own) in errors.iter().enumerate() {
                @if place > 0 { " and by " }
                b class="ca" { (text(own, 1)) } (own.whose())
            }
            ", of which the sensors' noise is a part. What could still be hidden stands below."
        }
    }
}

/// Budgets of the robots that are worst off.
fn budgets(diagnosis: &Diagnosis<'_>) -> Vec<BudgetRow> {
    let answer = diagnosis.answer;
    let numbered = diagnosis.numbered();
    let mut robots: Vec<&str> = Vec::new();
    let mut order: Vec<&Budget> = answer.budget.iter().collect();
    order.sort_by(|a, b| b.before.total_cmp(&a.before));
    for own in order {
        if !robots.contains(&own.robot.as_str()) && robots.len() < BUDGETS {
            robots.push(&own.robot);
        }
    }
    let several = robots.len() > 1;
    let mut rows = Vec::new();
    for (unit, title) in [("m", "Position"), ("rad", "Heading")] {
        let (factor, shown) = shown_unit(unit);
        let own = |robot: &str| {
            let mut own = answer.budget.iter();
            own.find(|own| own.robot == robot && own.unit == unit)
        };
        let largest = robots.iter().filter_map(|robot| own(robot));
        let scale = largest.fold(0.0, |most: f64, own| most.max(own.before.max(own.after)));
        for robot in &robots {
            let Some(own) = own(robot) else { continue };
            let parts = own.parts.iter().map(|part| {
                let effects = part.name.split(" + ");
                let of_part = |f: &Finding| {
                    f.robot == own.robot && effects.clone().any(|effect| effect == f.effect)
                };
                let numbers = numbered.iter().filter(|(_, _, f)| of_part(f));
                let names: Vec<&str> = effects.clone().map(name).collect();
                Part {
                    numbers: numbers.map(|(number, ..)| *number).collect(),
                    name: names.join(" + "),
                    share: factor * part.share,
                    kind: match part.name.as_str() {
                        "unexplained" => PartKind::Unexplained,
                        "sensor noise" => PartKind::Noise,
                        _ => PartKind::Found,
                    },
                }
            });
            rows.push(BudgetRow {
                title: if several {
                    format!("{robot} {}", title.to_lowercase())
                } else {
                    title.to_owned()
                },
                caption: format!("{} s ahead", fixed(answer.held_out.horizon_s, 0)),
                unit: shown.to_owned(),
                ends: [factor * own.before, factor * own.after],
                parts: parts.collect(),
                is_thin: unit == "rad" && rows.iter().any(|row: &BudgetRow| !row.is_thin),
                scale: factor * scale,
            });
        }
    }
    rows
}

fn path_figure(path: &Paths, robot: Option<&str>) -> Markup {
    let all = || path.seen.iter().chain(&path.before).chain(&path.after);
    let [x, y] = floor_scales(all().copied());
    let way = |words: &str| format!("{words} of the tracked point on the floor, in metres");
    let end = |points: &[(f64, f64)]| points.iter().rev().find(|p| p.0.is_finite()).copied();
    let apart = |points: &[(f64, f64)]| {
        let (seen, own) = (end(&path.seen)?, end(points)?);
        Some(100.0 * (seen.0 - own.0).hypot(seen.1 - own.1))
    };
    let frame = Frame::floor(x, y, way("Measured and predicted path"))
        .x_axis("m")
        .trail(Ink::Measured, &path.seen)
        .trail(Ink::Before, &path.before)
        .trail(Ink::After, &path.after);
    let start = path.seen.iter().find(|p| p.0.is_finite()).copied();
    let frame = match start {
        Some(start) => frame.dots(Ink::Measured, &[start], 9.0),
        None => frame,
    };
    let driven = if path.by_wheels {
        "the wheels alone"
    } else {
        "the commands alone"
    };
    let length = fixed(path.span_s[1] - path.span_s[0], 0);
    html! {
        figure class="pathf" {
            h2 { "Path" @if let Some(robot) = robot { " of " (robot) } }
            p class="legend" {
                span class="cr" { i class="kl rf" {} "measured" }
                span class="cb" { i class="kl bf" {} "before" }
                @if !path.after.is_empty() { span class="ca" { i class="kl af" {} "after" } }
            }
            (frame.markup())
            figcaption {
                @if path.in_pieces {
                    (length) " s in pieces of 5 s, each on " (driven) " from a fitted start."
                } @else {
                    (length) " s on " (driven) ": at the end "
                    @if let Some(before) = apart(&path.before) { b class="cb" { (short(before)) } }
                    @if let Some(after) = apart(&path.after) { " → " b class="ca" { (short(after)) } }
                    " cm off."
                }
            }
        }
    }
}

fn warnings(answer: &Answer) -> Markup {
    let all = &answer.warnings;
    html! {
        @for own in all.iter().take(WARNINGS) {
            p class="note" {
                @if let Some(robot) = &own.robot { b { (robot) } ": " }
                (own.statement) ". " (capital(&own.remedy)) "."
            }
        }
        @if all.len() > WARNINGS {
            details { summary { (all.len() - WARNINGS) " more notes on the data" }
                @for own in all.iter().skip(WARNINGS) {
                    p class="small" { (own.recording) @if let Some(robot) = &own.robot { ", " (robot) }
                        ": " (own.statement) "; " (own.remedy) "." }
                }
            }
        }
    }
}
