//! Timing of every stream: rate, jitter, gaps, repeated times.

use super::report::{Finding, RobotReport, Severity, StreamReport};
use crate::recording::Robot;
use crate::table::{CellsView, StreamKind, TableView};

/// Shortest gap, in median time steps.
const MIN_GAP_STEPS: f64 = 5.0;
/// Shortest gap (s); a gap is longer than both limits.
const MIN_GAP_S: f64 = 0.1;
/// A stream with at least [`MANY_ROWS`] rows and a lower rate (Hz) has times in milliseconds.
const MIN_RATE_HZ: f64 = 0.2;
/// Number of rows from which on the rate is judged.
const MANY_ROWS: usize = 50;
/// Repeated times are reported if more than one row in this many repeats a time.
const REPEATED_ONE_IN: usize = 20;

/// The report on a robot's streams. Adds findings about their timing.
pub(super) fn report(robot: &Robot, findings: &mut Vec<Finding>) -> RobotReport {
    let mut streams = Vec::new();
    for kind in StreamKind::ALL {
        if let Some(table) = TableView::of(robot, kind) {
            let report = stream_report(kind, &table);
            judge(&robot.name, &report, findings);
            streams.push(report);
        }
    }
    RobotReport {
        robot: robot.name.clone(),
        streams,
    }
}

fn stream_report(kind: StreamKind, table: &TableView<'_>) -> StreamReport {
    let steps: Vec<f64> = table
        .t_s
        .iter()
        .zip(table.t_s.iter().skip(1))
        .map(|(a, b)| b - a)
        .collect();
    let median_s = median(steps.clone()).filter(|step| *step > 0.0);
    let is_gap = |step: f64| step > MIN_GAP_S.max(MIN_GAP_STEPS * median_s.unwrap_or(0.0));
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
            let deviations = steps.iter().map(|step| (step - median_s).abs()).collect();
            median(deviations).map(|deviation| deviation / median_s)
        }),
        gaps_s: pairs
            .filter(|(a, b)| is_gap(**b - **a))
            .map(|(a, b)| [*a, *b])
            .collect(),
        repeated_times: steps.iter().filter(|step| **step == 0.0).count(),
        empty_cells: table
            .columns
            .iter()
            .map(|(_, cells)| empty_cells(cells))
            .sum(),
    }
}

fn empty_cells(cells: &CellsView<'_>) -> usize {
    match cells {
        CellsView::Numbers(cells) => cells.iter().filter(|cell| cell.is_nan()).count(),
        CellsView::Counts(cells) => cells.iter().filter(|cell| cell.is_none()).count(),
    }
}

/// The median (of an even number of items, the upper one); `None` of an empty list.
pub(super) fn median(mut numbers: Vec<f64>) -> Option<f64> {
    let middle = numbers.len() / 2;
    if numbers.is_empty() {
        return None;
    }
    let (_, median, _) = numbers.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

/// Adds findings about the timing of a stream.
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
    // Real recordings of many rows do not have several seconds between rows.
    if report.rows >= MANY_ROWS && report.rate_hz.is_some_and(|rate| rate < MIN_RATE_HZ) {
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
    if report.repeated_times * REPEATED_ONE_IN > report.rows {
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
