//! Rates, gaps and jitter of every stream.

use super::report::{Finding, RobotReport, Severity, StreamReport};
use crate::recording::Robot;
use crate::table::{CellsView, StreamKind, TableView};

/// A pause is a gap above this many medians …
const GAP_MEDIANS: f64 = 5.0;
/// … and above this (s).
const GAP_S: f64 = 0.1;

/// The streams of a robot, with findings about their times.
pub(super) fn of(robot: &Robot, findings: &mut Vec<Finding>) -> RobotReport {
    let mut streams = Vec::new();
    for kind in StreamKind::ALL {
        if let Some(table) = TableView::of(robot, kind) {
            let report = stream(kind, &table);
            judge(&robot.name, &report, findings);
            streams.push(report);
        }
    }
    RobotReport {
        robot: robot.name.clone(),
        streams,
    }
}

fn stream(kind: StreamKind, table: &TableView<'_>) -> StreamReport {
    let steps: Vec<f64> = table
        .t_s
        .iter()
        .zip(table.t_s.iter().skip(1))
        .map(|(a, b)| b - a)
        .collect();
    let median_s = median(steps.clone()).filter(|step| *step > 0.0);
    let is_gap = |step: f64| step > GAP_S.max(GAP_MEDIANS * median_s.unwrap_or(0.0));
    let pairs = table.t_s.iter().zip(table.t_s.iter().skip(1));
    StreamReport {
        stream: kind.name().to_owned(),
        columns: table
            .columns
            .iter()
            .map(|(name, _)| (*name).to_owned())
            .collect(),
        rows: table.t_s.len(),
        span_s: table
            .t_s
            .first()
            .zip(table.t_s.last())
            .map(|(a, b)| [*a, *b]),
        rate_hz: median_s.map(|step| 1.0 / step),
        jitter: median_s.and_then(|median_s| {
            let off = steps.iter().map(|step| (step - median_s).abs()).collect();
            median(off).map(|off| off / median_s)
        }),
        gaps_s: pairs
            .filter(|(a, b)| is_gap(**b - **a))
            .map(|(a, b)| [*a, *b])
            .collect(),
        repeated_times: steps.iter().filter(|step| **step == 0.0).count(),
        empty_cells: table.columns.iter().map(|(_, cells)| empty(cells)).sum(),
    }
}

fn empty(cells: &CellsView<'_>) -> usize {
    match cells {
        CellsView::Numbers(cells) => cells.iter().filter(|cell| cell.is_nan()).count(),
        CellsView::Counts(cells) => cells.iter().filter(|cell| cell.is_none()).count(),
    }
}

/// The median, if there is any number.
pub(super) fn median(mut numbers: Vec<f64>) -> Option<f64> {
    let middle = numbers.len() / 2;
    if numbers.is_empty() {
        return None;
    }
    let (_, median, _) = numbers.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

fn judge(robot: &str, report: &StreamReport, findings: &mut Vec<Finding>) {
    let stream = &report.stream;
    if report.rows < 2 {
        let statement = format!("{stream} has {} rows", report.rows);
        findings.push(Finding::new(
            Severity::Warning,
            robot,
            "too_few_rows",
            statement,
            "record for longer",
        ));
        return;
    }
    if !report.gaps_s.is_empty() {
        let total: f64 = report.gaps_s.iter().map(|[a, b]| b - a).sum();
        let longest = report.gaps_s.iter().map(|[a, b]| b - a).fold(0.0, f64::max);
        let statement = format!(
            "{stream} pauses {} times, {total:.2} s in all, {longest:.2} s the longest",
            report.gaps_s.len()
        );
        findings.push(Finding::new(
            Severity::Note,
            robot,
            "gaps",
            statement,
            "look for a logger that stalls or a sensor that loses sight",
        ));
    }
    // Nobody records fifty rows with five seconds and more between them.
    if report.rows >= 50 && report.rate_hz.is_some_and(|rate| rate < 0.2) {
        let statement = format!(
            "{stream} has a row every {:.0} s",
            1.0 / report.rate_hz.unwrap_or(1.0)
        );
        findings.push(Finding::new(
            Severity::Warning,
            robot,
            "units",
            statement,
            "look whether t_s is in milliseconds",
        ));
    }
    if report.repeated_times * 20 > report.rows {
        let statement = format!("{} rows of {stream} repeat a time", report.repeated_times);
        findings.push(Finding::new(
            Severity::Warning,
            robot,
            "repeated_times",
            statement,
            "stamp with the sensor's time, not with a coarser one",
        ));
    }
}
