//! What was ruled out down to which size, what could still be there, what was not judged, and what cannot be told apart.

use maud::{Markup, html};
use slipstream_answer::{Figures, Finding, Limit, Seen, manoeuvre};
use slipstream_bus::RobotModel;

use super::diagnosis::Diagnosis;
use crate::effect_words::{driver, name, scale_of};
use crate::parts::{DotRow, badge, dot_table, short, shown_unit, with_unit};

/// Rows that are shown at once; the others can be opened.
const SHOWN: usize = 10;

/// On which axis errors are compared: of the place, or of the heading where there are no places.
#[derive(Clone, Copy)]
struct Axis {
    part: usize,
    native: &'static str,
    head: &'static str,
    factor: f64,
    unit: &'static str,
}

impl Axis {
    fn new(in_place: bool) -> Self {
        let (part, native, head) = if in_place {
            (0, "m", "Position")
        } else {
            (1, "rad", "Heading")
        };
        let (factor, unit) = shown_unit(native);
        Self {
            part,
            native,
            head,
            factor,
            unit,
        }
    }
}

/// What was ruled out, down to which size.
pub(super) fn section(diagnosis: &Diagnosis<'_>, machines: &[&Figures]) -> Markup {
    let judged: Vec<&Figures> = machines
        .iter()
        .copied()
        .filter(|own| !own.limits.is_empty())
        .collect();
    let Some((first, others)) = judged.split_first() else {
        return html! {};
    };
    let what = if diagnosis.answer.against.is_empty() {
        "an effect"
    } else {
        "a change"
    };
    html! {
        section id="ruled-out" aria-labelledby="h-ruled-out" {
            h2 id="h-ruled-out" { "Ruled out, down to which size" }
            p class="sub" { "Beside the findings, " (what) " of this size would differ from nothing by 4.5 standard deviations. "
                "The dot is the error 5 s ahead that it could still cause; the dashed line is the error that is left."
                @if !others.is_empty() { " Of " (first.robot) "." } }
            (of_machine(diagnosis, first))
            @for own in others {
                details { summary { "Of " (own.robot) } (of_machine(diagnosis, own)) }
            }
        }
    }
}

/// The limits of one machine.
fn of_machine(diagnosis: &Diagnosis<'_>, own: &Figures) -> Markup {
    let model = diagnosis.model(&own.robot);
    let in_place = own.limits.iter().any(|limit| limit.error[0].is_some());
    let axis = Axis::new(in_place);
    let is_known = |limit: &&Limit| limit.size.is_some_and(f64::is_finite);
    let known = own.limits.iter().filter(is_known);
    let left = left(diagnosis, own, axis);
    let (small, large): (Vec<&Limit>, Vec<&Limit>) = known.partition(|limit| {
        left.is_none_or(|left| limit.error[axis.part].is_some_and(|error| error < left))
    });
    let mark = left.map(|left| (axis.factor * left, "error left"));
    let rows = |limits: &[&Limit]| {
        let rows = limits.iter().map(|limit| row(limit, axis, model.as_ref()));
        table(axis, mark, &rows.collect::<Vec<_>>())
    };
    let hidden = own.limits.iter().filter(|limit| !is_known(limit));
    let mut hidden: Vec<String> = hidden
        .map(|limit| name(limit.effect).to_lowercase())
        .collect();
    hidden.dedup();
    html! {
        @if !small.is_empty() { (rows(&small)) }
        @if !large.is_empty() {
            h3 class="more" { "Could still be there" }
            p class="sub" { "Up to this size these would not have been seen, and they could cause as much error as is left." }
            (rows(&large))
        }
        @if !hidden.is_empty() {
            details { summary { "Not visible in this recording: " (hidden.len()) " effects" }
                p class="small" { (hidden.join(", ")) "." } }
        }
        (not_judged(own))
    }
}

/// Rows on one axis; the first of them are open.
fn table(axis: Axis, mark: Option<(f64, &str)>, rows: &[DotRow]) -> Markup {
    let heads = ["Effect", "No larger than", axis.head];
    let (first, rest) = rows.split_at(rows.len().min(SHOWN));
    html! {
        (dot_table(heads, axis.unit, mark, first))
        @if !rest.is_empty() {
            details { summary { (rest.len()) " more, each with a smaller error" }
                (dot_table(heads, axis.unit, mark, rest)) }
        }
    }
}

fn row(limit: &Limit, axis: Axis, model: Option<&RobotModel>) -> DotRow {
    let (factor, unit) = scale_of(limit.effect, limit.parameter, limit.unit, model);
    let value = limit.error[axis.part].map(|error| axis.factor * error);
    let size = with_unit(&short(factor * limit.size.unwrap_or(0.0)), unit);
    DotRow {
        name: match (limit.word, limit.parameter.split_once(" over ")) {
            (Some(word), _) => format!("{}, {word}", name(limit.effect)),
            (None, Some((what, of))) => format!("A {what} that follows {}", driver(of).0),
            (None, None) => name(limit.effect).to_owned(),
        },
        id: format!("{}: {}", limit.effect, limit.parameter),
        size: match limit.seen {
            Seen::Below => format!("no less than {size}"),
            Seen::Above => size,
            Seen::Around(_) => format!("±{size}"),
        },
        value,
        text: value.map_or("–".to_owned(), |value| {
            with_unit(&short(value), axis.unit)
        }),
    }
}

/// The error that is left, in the unit of the budget.
fn left(diagnosis: &Diagnosis<'_>, own: &Figures, axis: Axis) -> Option<f64> {
    let mut budgets = diagnosis.answer.budget.iter();
    let budget = budgets.find(|budget| budget.robot == own.robot && budget.unit == axis.native)?;
    Some(budget.after)
}

/// Effects that were not looked at, and why.
fn not_judged(own: &Figures) -> Markup {
    let judged: Vec<&str> = own.limits.iter().map(|limit| limit.effect).collect();
    let left: Vec<&str> = slipstream_sim::effects::CATALOGUE
        .iter()
        .filter(|info| !info.kinematic && !info.is_table() && !judged.contains(&info.id))
        .map(|info| info.id)
        .collect();
    html! {
        @if own.forces.is_empty() && !left.is_empty() {
            details { summary { "Not judged: " (left.len()) " effects of forces" }
                p class="small" { "This robot is told speeds, or nothing is known of its commands. So nothing can be said about: "
                    span class="id" { (left.join(", ")) } ". Record torques or voltages, and give masses in robot.toml." } }
        }
    }
}

/// What cannot be told apart, and the manoeuvre that would tell.
pub(super) fn alike(diagnosis: &Diagnosis<'_>) -> Markup {
    let numbered = diagnosis.numbered();
    let twins: Vec<(usize, &Finding)> = numbered
        .iter()
        .filter(|(_, _, own)| !own.confused_with.is_empty())
        .map(|(number, _, own)| (*number, *own))
        .collect();
    html! {
        @if !twins.is_empty() {
            section id="alike" aria-labelledby="h-alike" {
                h2 id="h-alike" { "Cannot be told apart here" }
                p class="sub" { "The recording fits these equally well. The name given above is the likelier reading; "
                    "a manoeuvre would settle it." }
                div class="twins" { @for (number, finding) in twins { (twin(number, finding)) } }
            }
        }
    }
}

fn twin(number: usize, finding: &Finding) -> Markup {
    let names: Vec<String> = finding
        .confused_with
        .iter()
        .map(|id| name(id).to_lowercase())
        .collect();
    let others = finding.confused_with.iter().map(String::as_str);
    let ids: Vec<&str> = std::iter::once(finding.effect.as_str())
        .chain(others)
        .collect();
    html! {
        div class="twin" {
            p { (badge(number)) " " b { (name(&finding.effect)) } " "
                span class="muted" { "or" } " " b { (names.join(", or ")) } }
            p class="id" { (ids.join(", ")) }
            p class="small" { b { "What would tell: " } (manoeuvre(&ids)) "." }
        }
    }
}
