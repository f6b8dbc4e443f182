//! Timing of every stream: rate, jitter, gaps, repeated times.

use super::report::{Finding, RobotReport, Severity, StreamReport};
use crate::rows::{RobotRows, Rows, median};
use crate::table::{Cells, StreamKind};

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
pub(super) fn report(robot: &RobotRows<'_>, findings: &mut Vec<Finding>) -> RobotReport {
    let mut streams = Vec::new();
    for (kind, rows) in &robot.streams {
        let report = stream_report(*kind, rows);
        judge(&robot.robot.name, &report, findings);
        streams.push(report);
    }
    RobotReport {
        robot: robot.robot.name.clone(),
        streams,
    }
}

fn stream_report(kind: StreamKind, rows: &Rows<'_>) -> StreamReport {
    let steps = rows.len().saturating_sub(1) as u64;
    let median_s = median(steps, &|selection| {
        visit_steps(rows, &mut |[a, b]| selection.add(b - a));
    });
    let median_s = median_s.filter(|step| *step > 0.0);
    let min_gap_s = MIN_GAP_S.max(MIN_GAP_STEPS * median_s.unwrap_or(0.0));
    let (mut gaps_s, mut repeated_times) = (Vec::new(), 0);
    visit_steps(rows, &mut |[a, b]| {
        if b - a > min_gap_s {
            gaps_s.push([a, b]);
        }
        repeated_times += usize::from(b - a == 0.0);
    });
    StreamReport {
        stream: kind.name().to_owned(),
        columns: column_names(rows),
        rows: rows.len(),
        span_s: rows.span_s(),
        rate_hz: median_s.map(|step| 1.0 / step),
        jitter: median_s.and_then(|median_s| {
            let deviation = median(steps, &|selection| {
                visit_steps(rows, &mut |[a, b]| selection.add((b - a - median_s).abs()));
            });
            deviation.map(|deviation| deviation / median_s)
        }),
        gaps_s,
        repeated_times,
        empty_cells: empty_cells(rows),
    }
}

/// Calls `visit` with the times of each row and the next one (s).
fn visit_steps(rows: &Rows<'_>, visit: &mut dyn FnMut([f64; 2])) {
    let mut last = None;
    rows.visit_times(&mut |times| {
        for t_s in times {
            if let Some(last) = last.replace(*t_s) {
                visit([last, *t_s]);
            }
        }
    });
}

fn column_names(rows: &Rows<'_>) -> Vec<String> {
    let columns = rows.empty().columns.iter();
    columns.map(|(name, _)| (*name).to_owned()).collect()
}

fn empty_cells(rows: &Rows<'_>) -> usize {
    let mut empty = 0;
    let mut cursor = rows.clone().cursor();
    while let Some(block) = cursor.next_block() {
        for (_, cells) in &block.columns {
            empty += match cells {
                Cells::Numbers(cells) => cells.iter().filter(|cell| cell.is_nan()).count(),
                Cells::Counts(cells) => cells.iter().filter(|cell| cell.is_none()).count(),
                Cells::Texts(_) => 0,
            };
        }
    }
    empty
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
        let statement = match report.gaps_s.len() {
            1 => format!("{stream} pauses once, for {total:.2} s"),
            count => format!(
                "{stream} pauses {count} times, {total:.2} s in all, {longest:.2} s the longest"
            ),
        };
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
