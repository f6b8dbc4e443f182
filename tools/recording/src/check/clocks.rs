//! Clocks: streams that do not overlap, and a pose that lags behind the other sources.

use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::{combine, cosine};
use crate::rows::{RobotRows, Rows};
use crate::table::StreamKind;

/// Time step of the comparison (s).
pub(super) const STEP_S: f64 = 0.1;
/// Largest lag that is searched (steps).
const MAX_LAG_STEPS: isize = 10;
/// Smallest lag that is reported (s).
const MIN_REPORTED_LAG_S: f64 = 0.05;
/// Smallest cosine similarity at which two sources count as the same motion.
const MIN_SIMILARITY: f64 = 0.9;

/// Adds findings about the clocks of a robot's streams. `windows` have the length [`STEP_S`].
pub(super) fn check(robot: &RobotRows<'_>, windows: &Windows, findings: &mut Vec<Finding>) {
    let span = |(kind, rows): &(StreamKind, Rows<'_>)| {
        let [start, end] = rows.span_s()?;
        Some((kind.name(), start, end))
    };
    let spans: Vec<(&str, f64, f64)> = robot.streams.iter().filter_map(span).collect();
    for (i, (first, start_a, end_a)) in spans.iter().enumerate() {
        for (second, start_b, end_b) in spans.iter().skip(i + 1) {
            let overlap = end_a.min(*end_b) - start_a.max(*start_b);
            let shorter = (end_a - start_a).min(end_b - start_b);
            if overlap < 0.5 * shorter {
                let statement = format!(
                    "{first} ({start_a} s to {end_a} s) and {second} ({start_b} s to {end_b} s) \
                     hardly overlap"
                );
                let remedy = "put all streams on one clock";
                let (id, robot) = ("no_overlap", &robot.robot.name);
                findings.push(Finding::new(Severity::Error, robot, id, statement, remedy));
            }
        }
    }
    lags(&robot.robot.name, windows, findings);
}

/// Adds a note for each source behind which the pose lags.
fn lags(robot: &str, windows: &Windows, findings: &mut Vec<Finding>) {
    let (wheels_v, mut wheels_w) = windows.wheel_twist();
    if wheels_w.is_empty() {
        wheels_w = combine(&windows.wheel_right, &windows.wheel_left, |r, l| r - l);
    }
    let pairs = [
        ("wheels", &windows.pose_w, &wheels_w),
        ("wheels", &windows.pose_v, &wheels_v),
        ("gyro", &windows.pose_w, &windows.gyro_w),
        ("command", &windows.pose_w, &windows.command_w),
        ("command", &windows.pose_v, &windows.command_v),
    ];
    let mut reported: Vec<&str> = Vec::new();
    for (other, pose, reference) in pairs {
        let Some(lag_s) = lag(pose, reference).filter(|_| !reported.contains(&other)) else {
            continue;
        };
        reported.push(other);
        if lag_s.abs() > MIN_REPORTED_LAG_S {
            let word = if lag_s > 0.0 { "behind" } else { "before" };
            let statement = format!("the pose is about {:.2} s {word} the {other}", lag_s.abs());
            let remedy = "a latency, an offset between clocks, or slip: the diagnosis tells which";
            findings.push(Finding::new(
                Severity::Note,
                robot,
                "lag",
                statement,
                remedy,
            ));
        }
    }
}

/// The lag (s) of `late` behind `early` with the largest cosine similarity, interpolated by a parabola
/// through the maximum and its neighbours. `None` if the two are not the same motion.
fn lag(late: &[f64], early: &[f64]) -> Option<f64> {
    let (late, early) = (smooth(late), smooth(early));
    let cosines: Vec<f64> = (-MAX_LAG_STEPS..=MAX_LAG_STEPS)
        .map(|shift| cosine_at(&late, &early, shift))
        .collect::<Option<_>>()?;
    let best = (1..cosines.len() - 1).max_by(|a, b| cosines[*a].total_cmp(&cosines[*b]))?;
    let [left, top, right] = [cosines[best - 1], cosines[best], cosines[best + 1]];
    let curvature = left - 2.0 * top + right;
    // A weak maximum, or one hardly better than no lag, is not significant.
    let no_lag = cosines[MAX_LAG_STEPS as usize];
    let is_clear = 1.0 - no_lag > 1.5 * (1.0 - top) || best == MAX_LAG_STEPS as usize;
    if top < MIN_SIMILARITY || !is_clear || curvature >= 0.0 || top < left || top < right {
        return None;
    }
    let offset = 0.5 * (left - right) / curvature;
    Some((best as f64 - MAX_LAG_STEPS as f64 + offset) * STEP_S)
}

/// Moving average over five steps: the difference of a noisy pose is then taken over half a second.
fn smooth(list: &[f64]) -> Vec<f64> {
    list.windows(5)
        .map(|part| part.iter().sum::<f64>() / 5.0)
        .collect()
}

/// The cosine similarity of the two lists with the first moved back by `shift` steps.
fn cosine_at(late: &[f64], early: &[f64], shift: isize) -> Option<f64> {
    let from = |list: &[f64], by: isize| {
        let by = usize::try_from(by).unwrap_or(0).min(list.len());
        list.iter().skip(by).copied().collect::<Vec<f64>>()
    };
    cosine(&from(late, shift), &from(early, -shift))
}
