//! Small parts: verdict, numbered badge, interval glyph, code box, budget, table, dot table, stacked bars.

use maud::{Markup, PreEscaped, html};

use super::number::{fixed, short};
use super::scale::Scale;

/// How a verdict looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// All is well.
    Good,
    /// Some of it is.
    Part,
    /// It is not.
    Bad,
}

const TICK: &str = "<svg width='14' height='14' viewBox='0 0 14 14' aria-hidden='true'><path d='M2.5 7.5l3 3 6-7' fill='none' stroke='currentColor' stroke-width='1.8'/></svg>";
const FULL: &str = "<svg width='14' height='14' viewBox='0 0 14 14' aria-hidden='true'><circle cx='7' cy='7' r='5' fill='currentColor'/></svg>";
const HALF: &str = "<svg width='14' height='14' viewBox='0 0 14 14' aria-hidden='true'><circle cx='7' cy='7' r='5' fill='none' stroke='currentColor' stroke-width='1.6'/><path d='M7 2a5 5 0 0 0 0 10z' fill='currentColor'/></svg>";
const RING: &str = "<svg width='14' height='14' viewBox='0 0 14 14' aria-hidden='true'><circle cx='7' cy='7' r='5' fill='none' stroke='currentColor' stroke-width='1.6'/></svg>";
const APART: &str = "<svg width='14' height='14' viewBox='0 0 14 14' aria-hidden='true'><path d='M2 11C6 11 6 4 12 3M2 11c6 0 7-3 10-3' fill='none' stroke='currentColor' stroke-width='1.6'/></svg>";

/// Pictures of chips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Icon {
    /// A tick.
    Tick,
    /// A full disc.
    Full,
    /// A half disc.
    Half,
    /// A ring.
    Ring,
    /// Two lines that part.
    Apart,
}

/// The first lines of a page: chip and facts, the answer in a sentence, what it buys.
pub fn verdict(
    tone: Tone,
    icon: Icon,
    chip: &str,
    facts: &str,
    answer: &str,
    lead: &Markup,
) -> Markup {
    let tone = match tone {
        Tone::Good => "chip good",
        Tone::Part => "chip part",
        Tone::Bad => "chip bad",
    };
    let icon = match icon {
        Icon::Tick => TICK,
        Icon::Full => FULL,
        Icon::Half => HALF,
        Icon::Ring => RING,
        Icon::Apart => APART,
    };
    html! {
        div class="verdict" {
            div class="kick" { span class=(tone) { (PreEscaped(icon)) (chip) } span { (facts) } }
            h1 { (answer) }
            p class="lead" { (lead) }
        }
    }
}

/// The number of a finding.
pub fn badge(number: usize) -> Markup {
    html! { span class="n" { (number) } }
}

/// An estimate on an axis from what was assumed to the far end of its interval.
pub fn glyph(was: Option<f64>, estimate: f64, interval: [f64; 2], words: &str) -> Markup {
    let ends = [was.unwrap_or(estimate), estimate, interval[0], interval[1]];
    let finite = || ends.into_iter().filter(|value| value.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    let width = (high - low).max(1e-300);
    let at = |value: f64| 12.0 + 76.0 * ((value - low) / width).clamp(0.0, 1.0);
    let bar = interval.map(|end| if end.is_finite() { at(end) } else { 50.0 });
    html! {
        span class="ig" role="img" aria-label=(words) {
            @if let Some(was) = was { i class="w" style=(format!("left:{:.1}%", at(was))) {} }
            i class="r" style=(format!("left:{:.1}%;width:{:.1}%", bar[0], (bar[1] - bar[0]).max(1.0))) {}
            i class="e" style=(format!("left:{:.1}%", at(estimate))) {}
        }
    }
}

/// Lines to copy, under a title and where they belong.
pub fn code_box(id: &str, title: &str, place: &str, text: &str) -> Markup {
    html! {
        div class="box" {
            h3 { (title) " " span { (place) } }
            pre id=(id) { @for line in text.lines() { span class="line" { (line) "\n" } } }
            button class="btn noprint" data-copy=(id) aria-label=(format!("Copy {title}")) { "Copy" }
        }
    }
}

/// A command to copy.
pub fn command(id: &str, text: &str) -> Markup {
    html! {
        div class="cmd" {
            pre id=(id) { (text) }
            button class="btn noprint" data-copy=(id) aria-label="Copy the command" { "Copy" }
        }
    }
}

/// A part of an error budget.
#[derive(Debug, Clone)]
pub struct Part {
    /// Numbers of its findings; none for what is no finding.
    pub numbers: Vec<usize>,
    /// What it is.
    pub name: String,
    /// How much, in the unit of the budget.
    pub share: f64,
    /// What it is drawn like.
    pub kind: PartKind,
}

/// What a part of a budget is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartKind {
    /// A finding takes it away.
    Found,
    /// Nothing explains it.
    Unexplained,
    /// The sensor does it.
    Noise,
}

/// One row of an error budget.
#[derive(Debug, Clone)]
pub struct BudgetRow {
    /// What is counted, such as `Position`.
    pub title: String,
    /// Where or how far ahead.
    pub caption: String,
    /// `cm`, `°`, …
    pub unit: String,
    /// Error before and after.
    pub ends: [f64; 2],
    /// Parts that add up to the error before.
    pub parts: Vec<Part>,
    /// Drawn low: of second rank.
    pub is_thin: bool,
    /// The largest error of all rows on the same scale.
    pub scale: f64,
}

/// A number with a unit: degrees stand close to their number.
pub fn with_unit(number: &str, unit: &str) -> String {
    match unit {
        "" => number.to_owned(),
        "°" | "%" => format!(
            "{number}{}{unit}",
            if unit == "%" { "\u{202f}" } else { "" }
        ),
        unit => format!("{number} {unit}"),
    }
}

/// Error budgets, one row each.
pub fn budget(rows: &[BudgetRow]) -> Markup {
    html! {
        div class="budget" { @for row in rows { (budget_row(row)) } }
    }
}

fn budget_row(row: &BudgetRow) -> Markup {
    let [before, after] = row.ends;
    let drawn: Vec<&Part> = row
        .parts
        .iter()
        .filter(|part| part.share > 0.002 * before)
        .collect();
    let sum: f64 = drawn.iter().map(|part| part.share).sum();
    let words = |value: f64| with_unit(&short(value), &row.unit);
    let class = |place: usize, part: &Part| match part.kind {
        PartKind::Found => ["s1", "s2", "s3"][place.min(2)],
        PartKind::Unexplained => "su",
        PartKind::Noise => "sn",
    };
    html! {
        div class="brow" {
            div class="l" { (row.title) small { (row.caption) } }
            div {
                div class="ends" {
                    span class="cb" { "before " (words(before)) }
                    span class="ca" { "after " (words(after)) }
                }
                div class=(if row.is_thin { "bar thin" } else { "bar" }) aria-hidden="true"
                    style=(format!("width:{:.1}%", 100.0 * (before / row.scale.max(1e-300)).clamp(0.02, 1.0))) {
                    @for (place, part) in drawn.iter().enumerate() {
                        span class=(class(place, part)) style=(format!("flex:{:.4}", part.share / sum.max(1e-300))) {
                            @for number in &part.numbers {
                                @if part.share / sum > 0.03 * part.numbers.len() as f64 { span class="n" { (number) } }
                            }
                        }
                    }
                }
                ul class="labs" {
                    @for (place, part) in drawn.iter().enumerate() {
                        li {
                            i class=(format!("sw {}", class(place, part))) {}
                            @for number in &part.numbers { (badge(*number)) }
                            span { (part.name) " " b { (words(part.share)) } }
                        }
                    }
                }
            }
        }
    }
}

/// A cell of a table: its text, and what it is sorted by.
#[derive(Debug, Clone)]
pub struct Cell {
    /// What is shown.
    pub content: Markup,
    /// What the column is sorted by; numbers stand on the right.
    pub key: Option<f64>,
}

impl Cell {
    /// A cell of text.
    pub fn text(text: impl AsRef<str>) -> Self {
        let text = text.as_ref();
        Self {
            content: html! { (text) },
            key: None,
        }
    }

    /// A cell with a number.
    pub fn number(key: f64, text: impl AsRef<str>) -> Self {
        Self {
            key: Some(if key.is_finite() { key } else { -1e300 }),
            ..Self::text(text)
        }
    }

    /// A cell with a count.
    pub fn count(count: u64) -> Self {
        Self::number(count as f64, fixed(count as f64, 0))
    }

    /// A cell of markup.
    pub fn markup(content: Markup) -> Self {
        Self { content, key: None }
    }
}

/// A table whose columns sort by a click on their heads. Wide tables scroll in themselves.
pub fn table(caption: &str, heads: &[&str], rows: &[Vec<Cell>]) -> Markup {
    let is_number = |column: usize| {
        rows.iter()
            .any(|row| row.get(column).is_some_and(|cell| cell.key.is_some()))
    };
    html! {
        div class="tw" tabindex="0" role="region" aria-label=(caption) {
            table {
                caption class="sr" { (caption) }
                thead { tr {
                    @for (column, head) in heads.iter().enumerate() {
                        th scope="col" aria-sort="none" class=(if is_number(column) { "num" } else { "" }) {
                            button { (head) }
                        }
                    }
                } }
                tbody { @for row in rows { tr {
                    @for (column, cell) in row.iter().enumerate() {
                        td class=(if is_number(column) { "num" } else { "" }) data-s=[cell.key] { (cell.content) }
                    }
                } } }
            }
        }
    }
}

/// A row of a dot table.
#[derive(Debug, Clone)]
pub struct DotRow {
    /// What it is about.
    pub name: String,
    /// Its id.
    pub id: String,
    /// The size in its own unit.
    pub size: String,
    /// The value on the axis; none where it cannot be said.
    pub value: Option<f64>,
    /// The value in words.
    pub text: String,
}

/// Rows on one axis: a dot at each value, a dashed line at `mark`.
pub fn dot_table(
    heads: [&str; 3],
    unit: &str,
    mark: Option<(f64, &str)>,
    rows: &[DotRow],
) -> Markup {
    let values = rows
        .iter()
        .filter_map(|row| row.value)
        .chain(mark.map(|(value, _)| value));
    let scale = Scale::around(values, true, 4);
    let at = |value: f64| 100.0 * scale.place(value).clamp(0.0, 1.0);
    let ticks = scale.ticks();
    html! {
        div class="tw" tabindex="0" role="region" aria-label=(heads[0]) {
            table class="ro" {
                thead { tr {
                    th scope="col" aria-sort="none" { button { (heads[0]) } }
                    th scope="col" class="num" { (heads[1]) }
                    th scope="col" class="dotc" {
                        span class="ax" {
                            @for (place, (value, text)) in ticks.iter().enumerate() {
                                span style=(format!("left:{:.1}%", at(*value))) {
                                    @if place + 1 == ticks.len() { (with_unit(text, unit)) } @else { (text) }
                                }
                            }
                            @if let Some((value, words)) = mark {
                                span class="rl cd" style=(format!("left:{:.1}%", at(value))) { (words) }
                            }
                        }
                    }
                    th scope="col" class="num" aria-sort="descending" { button { (heads[2]) } }
                } }
                tbody { @for row in rows { tr {
                    td { (row.name) @if !row.id.is_empty() { div class="id" { (row.id) } } }
                    td class="num" { (row.size) }
                    td class="dotc" data-s=[row.value] {
                        span class="dt" role="img" aria-label=(row.text) {
                            @if let Some((value, _)) = mark { i class="ref" style=(format!("left:{:.1}%", at(value))) {} }
                            @if let Some(value) = row.value {
                                i class="b" style=(format!("width:{:.1}%", at(value))) {}
                                i class="d" style=(format!("left:{:.1}%", at(value))) {}
                            }
                        }
                    }
                    td class="num" data-s=[row.value] { (row.text) }
                } } }
            }
        }
    }
}

/// A picture with the sentence that it shows.
pub fn card(
    number: Option<usize>,
    claim: &str,
    what: &str,
    picture: &Markup,
    words: &str,
) -> Markup {
    html! {
        figure class="card" {
            figcaption { h3 { @if let Some(number) = number { (badge(number)) " " } (claim) } (what) }
            (picture)
            p class="small" { (words) }
        }
    }
}
