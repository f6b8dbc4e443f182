//! The table of findings: what was, what is, how sure, what it takes away, what to do.

use maud::{Markup, html};
use slipstream_answer::{Answer, Finding};

use super::diagnosis::{Diagnosis, listed};
use super::errors::unexplained;
use crate::effect_words::{Shown, all_shown, name};
use crate::parts::{badge, capital, fixed, glyph, short, shown_unit, with_unit};

/// The table; empty where nothing was found and nothing is left.
pub(super) fn findings(diagnosis: &Diagnosis<'_>) -> Markup {
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
                    th scope="col" class="num" { "95 % interval" }
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
        p class="key of-gl" {
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
    let rows = all_shown(finding, model.as_ref());
    let word = finding
        .parameters
        .iter()
        .find_map(|own| own.text.as_deref());
    html! {
        tr {
            td class="own" {
                span class="nm" { (badge(number)) b { (name(&finding.effect)) } }
                div class="id" { (finding.effect) @if let Some(word) = word { ", " (word) } }
                @if several { div class="id" { "of " (finding.robot) } }
                @if let Some(runs) = &finding.runs {
                    div class="id" { "in " (listed(runs)) }
                }
            }
            @if rows.is_empty() {
                td class="own" colspan="5" { (finding.shape.clone().unwrap_or_default()) }
            } @else {
                td class="what" data-l="Parameter" { @for row in &rows { span class="ln" { (row.label) } } }
                td class="num" data-l="Was" { @for row in &rows { span class="ln" {
                    (row.was_words().unwrap_or_else(|| "–".to_owned()))
                } } }
                td class="num" data-l="Is" { @for row in &rows { span class="ln" { b { (row.is_words()) } } } }
                td class="num" data-l="95 % interval" { @for row in &rows { span class="ln cii" { (row.interval_words()) } } }
                td class="gl wide" { @for row in &rows { (glyph(row.was, row.is, row.interval, &sentence(row))) } }
            }
            td class="num own" data-l="Takes away" { @for words in taken(diagnosis.answer, finding) { span class="ln" { (words) } } }
            td class="do own" data-l="What to do" { (to_do(finding)) }
        }
    }
}

/// What to do, one line each; long names may break behind their underscores.
fn to_do(finding: &Finding) -> Markup {
    html! {
        @for action in finding.actions_beside_statement() {
            span class="act" {
                @for (place, part) in capital(action).split_inclusive('_').enumerate() {
                    @if place > 0 { wbr; }
                    (part)
                }
            }
        }
    }
}

/// The interval in words.
fn sentence(row: &Shown) -> String {
    let was = row.was_words();
    let was = was.map_or_else(String::new, |was| format!("was {was}, "));
    format!(
        "{}: {was}is {}, 95 % between {} and {}",
        row.label,
        row.is_words(),
        fixed(row.interval[0], row.digits),
        with_unit(&fixed(row.interval[1], row.digits), row.unit)
    )
}

/// What a finding takes away of each error, in words.
pub(super) fn taken(answer: &Answer, finding: &Finding) -> Vec<String> {
    let budgets = answer.budget.iter();
    let own = budgets.filter(|own| own.robot == finding.robot);
    let alike = |other: &&Finding| other.robot == finding.robot && other.effect == finding.effect;
    let several = answer.findings.iter().filter(alike).count() > 1;
    let shares = own.filter_map(|own| {
        let part = own.part_of(&finding.effect)?;
        let (factor, unit) = shown_unit(own.unit);
        let together = if several || part.is_shared() {
            " together"
        } else {
            ""
        };
        (part.share > 0.01 * own.before)
            .then(|| with_unit(&short(factor * part.share), unit) + together)
    });
    let words: Vec<String> = shares.collect();
    if words.is_empty() {
        vec!["–".to_owned()]
    } else {
        words
    }
}

fn rest_row(left: &[(f64, &'static str)]) -> Markup {
    let words: Vec<String> = left
        .iter()
        .map(|(value, unit)| with_unit(&short(*value), unit))
        .collect();
    html! {
        tr {
            td class="own" { span class="nm" { span class="n q" { "?" } b { "Unexplained" } } div class="id" { "no driver" } }
            td class="own" colspan="5" { "It follows none of the variables that were looked at." }
            td class="num own" data-l="Left" { @for words in &words { span class="ln" { (words) " left" } } }
            td class="do own" data-l="What to do" { "See the data below for jumps and gaps" }
        }
    }
}
