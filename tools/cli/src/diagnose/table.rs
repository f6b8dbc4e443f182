//! The findings as one table for the terminal: what, was, is, interval, worth; and below each, when it acts, what it
//! cannot be told from, and what to do.

use std::fmt::Write as _;

use slipstream_answer::{Answer, Finding, ParameterEstimate};
use slipstream_sim::effects::{Role, find};

use super::text::{SMALL_PART, size};

/// Cells of a row: what, was, is, 95 % interval, worth.
type RowCells = [String; 5];

/// A line of the table: cells below their headings, or text.
enum TableLine {
    Cells(RowCells),
    Text(String),
}

/// The table; empty without findings. `with_statements`: with the sentence of each finding.
pub(super) fn table(answer: &Answer, with_statements: bool) -> String {
    if answer.findings.is_empty() {
        return String::new();
    }
    let horizon = format!("worth over {:.0} s", answer.held_out.horizon_s);
    let head = ["what", "was", "is", "95 % interval", &horizon];
    let mut lines = vec![TableLine::Cells(head.map(str::to_owned))];
    for finding in &answer.findings {
        rows(answer, finding, &mut lines);
        if with_statements {
            lines.push(TableLine::Text(finding.statement.clone()));
        }
    }
    laid_out(&lines)
}

/// The lines of one finding.
fn rows(answer: &Answer, finding: &Finding, lines: &mut Vec<TableLine>) {
    let robots = answer.findings.iter().map(|own| &own.robot);
    let is_of_one = robots.clone().all(|robot| *robot == finding.robot);
    let what = match is_of_one {
        true => finding.effect.clone(),
        false => format!("{} {}", finding.robot, finding.effect),
    };
    let empty = String::new;
    let title = [what, empty(), empty(), empty(), worth(answer, finding)];
    lines.push(TableLine::Cells(title));
    let texts = |own: &&ParameterEstimate| own.text.is_none();
    for parameter in finding.parameters.iter().filter(texts) {
        lines.push(TableLine::Cells(parameter_row(&finding.effect, parameter)));
    }
    let mut say = |text: String| lines.push(TableLine::Text(text));
    for parameter in &finding.parameters {
        if let Some(text) = &parameter.text {
            say(format!("{}: {text}", parameter.name));
        }
    }
    if let Some(shape) = &finding.shape {
        say(shape.clone());
    }
    say(format!("acts {}", when(finding)));
    if let Some(runs) = &finding.runs {
        say(format!("in {}", runs.join(", ")));
    }
    if !finding.confused_with.is_empty() {
        let others = finding.confused_with.join(" or ");
        say(format!("this recording cannot tell it from {others}"));
    }
    for action in &finding.actions {
        say(format!("- {action}"));
    }
}

/// A parameter: its name, what the model says, what the recording says, and how sure.
fn parameter_row(effect: &str, parameter: &ParameterEstimate) -> RowCells {
    let info = find(effect).and_then(|own| own.parameter(&parameter.name));
    let is_factor = info.is_some_and(|own| own.role == Role::Factor);
    let digits = parameter.ci95.map_or(3, digits);
    let number = |value: f64| format!("{value:.digits$}");
    let unit = match parameter.unit.as_str() {
        "1" | "" => String::new(),
        unit => format!(" {unit}"),
    };
    let was = match parameter.nominal {
        Some(nominal) => number(nominal),
        None if is_factor => "1".to_owned(),
        None => "none".to_owned(),
    };
    [
        format!("  {}", parameter.name),
        was,
        parameter.estimate.map_or_else(String::new, number),
        parameter.ci95.map_or_else(String::new, |[low, high]| {
            format!("{} to {}{unit}", number(low), number(high))
        }),
        String::new(),
    ]
}

/// So many digits after the point show two digits of an interval's width.
fn digits([low, high]: [f64; 2]) -> usize {
    let width = (high - low).abs().max(1e-9);
    (1.0 - width.log10().floor()).clamp(0.0, 9.0) as usize
}

/// What a finding costs in position and heading.
fn worth(answer: &Answer, finding: &Finding) -> String {
    let own = answer
        .budget
        .iter()
        .filter(|own| own.robot == finding.robot);
    let parts = own.filter_map(|budget| {
        let part = budget.part_of(&finding.effect)?;
        let is_small = part.share.abs() < SMALL_PART * budget.before;
        let together = if part.is_shared() { " together" } else { "" };
        (!is_small).then(|| size(part.share, budget.unit) + together)
    });
    let parts: Vec<String> = parts.collect();
    parts.join(", ")
}

/// When a finding is at work, in words.
fn when(finding: &Finding) -> String {
    let condition = &finding.place.condition;
    match finding.place.intervals_s.as_slice() {
        [[from, to]] if condition.is_empty() => format!("from {from:.2} to {to:.2} s"),
        [] if condition.is_empty() => "at times that are not known".to_owned(),
        many if condition.is_empty() => {
            let first: Vec<String> = many
                .iter()
                .take(4)
                .map(|[from, to]| format!("{from:.2} to {to:.2} s"))
                .collect();
            let more = many.len().saturating_sub(4);
            let more = if more > 0 {
                format!(" and {more} times more")
            } else {
                String::new()
            };
            format!("from {}{more}", first.join(", "))
        }
        _ => condition.clone(),
    }
}

/// The lines with their cells below each other; text is indented.
fn laid_out(lines: &[TableLine]) -> String {
    let cells = lines.iter().filter_map(|line| match line {
        TableLine::Cells(cells) => Some(cells),
        TableLine::Text(_) => None,
    });
    let mut widths = [0; 5];
    for row in cells {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = cell.chars().count().max(*width);
        }
    }
    let mut text = String::new();
    for line in lines {
        let row = match line {
            TableLine::Text(own) => format!("    {own}"),
            TableLine::Cells([what, was, is, interval, worth]) => {
                let [a, b, c, d, _] = widths;
                format!("{what:a$}  {was:>b$}  {is:>c$}  {interval:>d$}  {worth}")
            }
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", row.trim_end());
    }
    text
}
