//! The first screen of a diagnosis: verdict, error budget, path before and after, findings and what to do.

use std::fmt::Write as _;

use maud::{Markup, html};
use slipstream_bus::{Parameter, RobotModel};
use slipstream_diagnose::{Answer, Budget, Finding, Paths, Verdict};
use slipstream_recording::robot_toml;

use super::diagnosis::{Diagnosis, listed};
use super::errors::{Error, errors, unexplained};
use super::words::{Shown, action, name, shown};
use crate::parts::{
    BudgetRow, Frame, Icon, Ink, Part, PartKind, Tone, badge, budget, capital, code_box, fixed,
    floor_scales, glyph, interval, short, verdict, with_unit,
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

fn chip(answer: &Answer) -> (Tone, Icon, &'static str) {
    let known = answer.findings.iter().any(|own| own.effect != "unknown");
    match (answer.verdict, known) {
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
        @if errors.is_empty() {
            "In standard deviations of its sensors, a prediction over " (horizon) " s is off by "
            b class="ca" { (short(answer.held_out.nrmse_after)) } " instead of "
            b class="cb" { (short(answer.held_out.nrmse_before)) } "; noise alone gives 1."
        } @else if named {
            "With " @if answer.findings.len() == 1 { "this" } @else { "these" } " corrected, a prediction over "
            (horizon) " s misses by "
            @for (place, own) in errors.iter().enumerate() {
                @if place > 0 { ", and by " }
                b class="ca" { (text(own, 1)) } " instead of " b class="cb" { (text(own, 0)) }
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
                b class="ca" { (text(own, 1)) }
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
    for (unit, title, shown, factor) in [
        ("m", "Position", "cm", 100.0),
        ("rad", "Heading", "°", 1.0_f64.to_degrees()),
    ] {
        let own = |robot: &str| {
            let mut own = answer.budget.iter();
            own.find(|own| own.robot == robot && own.unit == unit)
        };
        let largest = robots.iter().filter_map(|robot| own(robot));
        let scale = largest.fold(0.0, |most: f64, own| most.max(own.before.max(own.after)));
        for robot in &robots {
            let Some(own) = own(robot) else { continue };
            let parts = own.parts.iter().map(|part| {
                let number = numbered
                    .iter()
                    .find(|(_, _, f)| f.robot == own.robot && f.effect == part.name);
                Part {
                    number: number.map(|(number, ..)| *number),
                    name: name(&part.name).to_owned(),
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

fn findings(diagnosis: &Diagnosis<'_>) -> Markup {
    let numbered = diagnosis.numbered();
    let answer = diagnosis.answer;
    let left = unexplained(answer);
    if numbered.is_empty() && left.is_empty() {
        return html! {};
    }
    let several = diagnosis.robots().len() > 1;
    html! {
        h2 class="sr" { "What the model leaves out" }
        div class="tw" tabindex="0" role="region" aria-label="What the model leaves out" {
            table class="find" {
                thead { tr {
                    th scope="col" { "Left out of the model" }
                    th scope="col" { span class="sr" { "Parameter" } }
                    th scope="col" class="num cb" { "Was" }
                    th scope="col" class="num ca" { "Is" }
                    th scope="col" { "95 % interval" }
                    th scope="col" class="gl wide" { span class="sr" { "Interval as a picture" } }
                    th scope="col" class="num" { "Takes away" }
                    th scope="col" { "What to do" }
                } }
                tbody {
                    @for (number, _, finding) in &numbered {
                        (finding_row(diagnosis, *number, finding, several))
                    }
                    @if !left.is_empty() { (rest_row(&left)) }
                }
            }
        }
        p class="key" {
            span { i class="k1" {} "the model's value" }
            span { i class="k2" {} "estimate with its 95 % interval, each on its own scale" }
        }
    }
}

fn finding_row(
    diagnosis: &Diagnosis<'_>,
    number: usize,
    finding: &Finding,
    several: bool,
) -> Markup {
    let model = diagnosis.model(&finding.robot);
    let rows: Vec<Shown> = finding
        .parameters
        .iter()
        .filter_map(|own| shown(&finding.effect, own, model.as_ref()))
        .collect();
    let word = finding
        .parameters
        .iter()
        .find_map(|own| own.text.as_deref());
    html! {
        tr {
            td {
                span class="nm" { (badge(number)) b { (name(&finding.effect)) } }
                div class="id" { (finding.effect) @if let Some(word) = word { ", " (word) } }
                @if several { div class="id" { "of " (finding.robot) } }
                @if let Some(runs) = &finding.runs {
                    div class="id" { "in " (listed(runs)) }
                }
            }
            @if rows.is_empty() {
                td colspan="5" { (finding.shape.clone().unwrap_or_default()) }
            } @else {
                td { @for row in &rows { span class="ln" { (row.label) } } }
                td class="num" { @for row in &rows { span class="ln" {
                    @match row.was { Some(was) => (with_unit(&fixed(was, row.digits.min(3)), row.unit)), None => "–" }
                } } }
                td class="num" { @for row in &rows { span class="ln" { b { (with_unit(&fixed(row.is, row.digits), row.unit)) } } } }
                td { @for row in &rows { span class="ln cii" { (interval(row.interval[0], row.interval[1], row.digits)) } } }
                td class="gl wide" { @for row in &rows { (glyph(row.was, row.is, row.interval, &sentence(row))) } }
            }
            td class="num" { (taken(diagnosis.answer, finding)) }
            td class="do" { (action(finding, model.as_ref())) }
        }
    }
}

/// The interval in words.
fn sentence(row: &Shown) -> String {
    let was = match row.was {
        Some(was) => format!(
            "was {}, ",
            with_unit(&fixed(was, row.digits.min(3)), row.unit)
        ),
        None => String::new(),
    };
    format!(
        "{}: {was}is {}, 95 % between {} and {}",
        row.label,
        with_unit(&fixed(row.is, row.digits), row.unit),
        fixed(row.interval[0], row.digits),
        with_unit(&fixed(row.interval[1], row.digits), row.unit)
    )
}

/// What a finding takes away of the error, in words.
fn taken(answer: &Answer, finding: &Finding) -> String {
    let degree = 1.0_f64.to_degrees();
    let own = answer
        .budget
        .iter()
        .filter(|own| own.robot == finding.robot);
    let shares = own.filter_map(|own| {
        let part = own.parts.iter().find(|part| part.name == finding.effect)?;
        let (factor, unit) = if own.unit == "m" {
            (100.0, "cm")
        } else {
            (degree, "°")
        };
        (part.share > 0.01 * own.before).then(|| with_unit(&short(factor * part.share), unit))
    });
    let words: Vec<String> = shares.collect();
    if words.is_empty() {
        "–".to_owned()
    } else {
        words.join(", ")
    }
}

fn rest_row(left: &[(f64, &'static str)]) -> Markup {
    let words: Vec<String> = left
        .iter()
        .map(|(value, unit)| with_unit(&short(*value), unit))
        .collect();
    html! {
        tr {
            td { span class="nm" { span class="n q" { "?" } b { "Unexplained" } } div class="id" { "no driver" } }
            td colspan="5" { "It follows none of the variables that were looked at." }
            td class="num" { (words.join(", ")) " left" }
            td class="do" { "See the data below for jumps and gaps" }
        }
    }
}

/// Lines to copy: what robot.toml gains, and the parameters of ros2_control's diff_drive_controller.
fn ready(diagnosis: &Diagnosis<'_>) -> Markup {
    let named = |robot: &str| {
        let mut own = diagnosis.answer.findings.iter();
        own.any(|own| own.robot == robot && own.effect != "unknown")
    };
    let models: Vec<&(String, RobotModel)> = diagnosis
        .improved
        .iter()
        .filter(|(robot, _)| named(robot))
        .collect();
    let Some((robot, model)) = models.first() else {
        return html! {};
    };
    let several = models.len() > 1;
    let place = if several {
        format!("of {robot}, by --improved")
    } else {
        "by --improved".to_owned()
    };
    let controller = controller(diagnosis, robot);
    html! {
        div class="boxes" {
            (code_box("toml", "robot.toml", &place, &effects_of(model)))
            @if let Some(lines) = controller {
                (code_box("yaml", "diff_drive_controller", "parameters", &lines))
            }
        }
    }
}

/// The effects of a model as its file lists them, numbers to five digits.
fn effects_of(model: &RobotModel) -> String {
    let mut rounded = model.clone();
    let to_digits = |value: &mut f64| {
        if let Ok(own) = format!("{value:.4e}").parse() {
            *value = own;
        }
    };
    for (_, parameter) in rounded
        .effects
        .iter_mut()
        .flat_map(|own| &mut own.parameters)
    {
        match parameter {
            Parameter::Number(value) => to_digits(value),
            Parameter::List(values) => values.iter_mut().for_each(to_digits),
            Parameter::Text(_) => {}
        }
    }
    let text = robot_toml::to_text(&rounded);
    let from = text.find("[effects]").unwrap_or(text.len());
    text[from..].trim_end().to_owned()
}

fn controller(diagnosis: &Diagnosis<'_>, robot: &str) -> Option<String> {
    let mut lines = String::new();
    for finding in diagnosis
        .answer
        .findings
        .iter()
        .filter(|own| own.robot == robot)
    {
        let keys: &[(&str, &str)] = match finding.effect.as_str() {
            "wheel_radius" => &[
                ("right_scale", "right_wheel_radius_multiplier"),
                ("left_scale", "left_wheel_radius_multiplier"),
            ],
            "track_width" => &[("scale", "wheel_separation_multiplier")],
            _ => &[],
        };
        for (parameter, key) in keys {
            let own = finding.parameters.iter().find(|own| own.name == *parameter);
            if let Some(own) = own.filter(|_| finding.runs.is_none()) {
                let digits = own.ci95.map_or(4, crate::parts::digits_of).max(3);
                let _ = write!(lines, "\n  {key}: {:.digits$}", own.estimate?);
            }
        }
    }
    (!lines.is_empty()).then(|| format!("ros__parameters:{lines}"))
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

/// The findings as Markdown, for a pull request.
pub(super) fn markdown(diagnosis: &Diagnosis<'_>) -> String {
    let answer = diagnosis.answer;
    let (_, _, chip) = chip(answer);
    let mut text = format!(
        "**slipstream diagnose** `{}`: {}. {}",
        diagnosis.subject,
        chip.to_lowercase(),
        diagnosis.sentence()
    );
    let errors: Vec<String> = errors(answer)
        .iter()
        .map(|own| {
            let [before, after] = own.ends.map(|end| with_unit(&short(end), own.unit));
            format!("{after} (before: {before})")
        })
        .collect();
    if !errors.is_empty() {
        let _ = write!(
            text,
            " A {} s prediction misses by {}.",
            fixed(answer.held_out.horizon_s, 0),
            errors.join(", ")
        );
    }
    text.push_str("\n\n| left out of the model | was | is (95 %) | takes away | what to do |\n|---|---|---|---|---|\n");
    for (_, _, finding) in diagnosis.numbered() {
        let model = diagnosis.model(&finding.robot);
        let rows: Vec<Shown> = finding
            .parameters
            .iter()
            .filter_map(|own| shown(&finding.effect, own, model.as_ref()))
            .collect();
        let was: Vec<String> = rows
            .iter()
            .map(|row| {
                row.was.map_or("–".to_owned(), |was| {
                    with_unit(&fixed(was, row.digits.min(3)), row.unit)
                })
            })
            .collect();
        let is: Vec<String> = rows
            .iter()
            .map(|row| {
                format!(
                    "{} {} ({})",
                    row.label,
                    with_unit(&fixed(row.is, row.digits), row.unit),
                    interval(row.interval[0], row.interval[1], row.digits)
                )
            })
            .collect();
        let _ = writeln!(
            text,
            "| {} {} `{}` | {} | {} | {} | {} |",
            finding.robot,
            name(&finding.effect).to_lowercase(),
            finding.effect,
            was.join(", "),
            is.join(", "),
            taken(answer, finding),
            action(finding, model.as_ref())
        );
    }
    text
}
