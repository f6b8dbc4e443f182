//! Clocks: streams that do not overlap, that lag behind each other, messages from the future.

use slipstream_bus::RobotModel;

use super::motion::cut;
use super::rates::median;
use super::report::{Finding, Severity};
use super::similarity::{agreement, combine};
use super::units::twist_of_wheels;
use crate::recording::{Recording, Robot};
use crate::table::{StreamKind, TableView};

/// Findings about the clocks of one robot's streams.
pub(super) fn of_robot(robot: &Robot, model: Option<&RobotModel>, findings: &mut Vec<Finding>) {
    let mut spans: Vec<(&str, f64, f64)> = Vec::new();
    for kind in StreamKind::ALL {
        let table = TableView::of(robot, kind);
        let ends = table.and_then(|table| Some((*table.t_s.first()?, *table.t_s.last()?)));
        spans.extend(ends.map(|(start, end)| (kind.name(), start, end)));
    }
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
                let (id, robot) = ("no_overlap", &robot.name);
                findings.push(Finding::new(Severity::Error, robot, id, statement, remedy));
            }
        }
    }
    lags(robot, model, findings);
}

/// Step of the comparison (s).
const STEP_S: f64 = 0.1;
/// Largest lag that is looked for, in steps.
const REACH: isize = 10;
/// A lag that is worth a note (s).
const WORTH_S: f64 = 0.05;

/// How far the pose lags behind what else tells the motion.
fn lags(robot: &Robot, model: Option<&RobotModel>, findings: &mut Vec<Finding>) {
    let windows = cut(robot, model, STEP_S);
    let (wheels_v, mut wheels_w) = twist_of_wheels(&windows);
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
    let mut said: Vec<&str> = Vec::new();
    for (other, pose, reference) in pairs {
        let Some(lag_s) = lag(pose, reference).filter(|_| !said.contains(&other)) else {
            continue;
        };
        said.push(other);
        if lag_s.abs() > WORTH_S {
            let word = if lag_s > 0.0 { "behind" } else { "before" };
            let statement = format!("the pose is about {:.2} s {word} the {other}", lag_s.abs());
            let remedy = "a latency, an offset between clocks, or slip: the diagnosis tells which";
            let (id, robot) = ("lag", &robot.name);
            findings.push(Finding::new(Severity::Note, robot, id, statement, remedy));
        }
    }
}

/// The time (s) by which `late` comes after `early`, where they are the same motion. Between steps
/// by the parabola through the three best.
fn lag(late: &[f64], early: &[f64]) -> Option<f64> {
    let (late, early) = (smooth(late), smooth(early));
    let cosine = |shift: isize| cosine_at(&late, &early, shift);
    let cosines: Vec<f64> = (-REACH..=REACH).map(cosine).collect::<Option<_>>()?;
    let best = (1..cosines.len() - 1).max_by(|a, b| cosines[*a].total_cmp(&cosines[*b]))?;
    let [before, top, after] = [cosines[best - 1], cosines[best], cosines[best + 1]];
    let curvature = before - 2.0 * top + after;
    // A weak maximum, or one hardly better than no lag, tells nothing.
    let none = cosines[REACH as usize];
    let clear = 1.0 - none > 1.5 * (1.0 - top) || best == REACH as usize;
    if top < 0.9 || !clear || curvature >= 0.0 || top < before || top < after {
        return None;
    }
    let between = 0.5 * (before - after) / curvature;
    Some((best as f64 - REACH as f64 + between) * STEP_S)
}

/// The mean of each item and the four after it: differences of a noisy pose over half a second.
fn smooth(list: &[f64]) -> Vec<f64> {
    list.windows(5)
        .map(|part| part.iter().sum::<f64>() / 5.0)
        .collect()
}

/// The cosine of the two lists when the first is moved back by `shift` steps.
fn cosine_at(late: &[f64], early: &[f64], shift: isize) -> Option<f64> {
    let from = |list: &[f64], by: isize| {
        let by = usize::try_from(by).unwrap_or(0).min(list.len());
        list.iter().skip(by).copied().collect::<Vec<f64>>()
    };
    agreement(&from(late, shift), &from(early, -shift)).map(|a| a.cosine)
}

/// Findings about the messages between robots.
pub(super) fn of_links(recording: &Recording, findings: &mut Vec<Finding>) {
    let Some(links) = &recording.links else {
        return;
    };
    let mut pairs: Vec<(&str, &str)> = links
        .messages
        .iter()
        .map(|message| (&*message.from, &*message.to))
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    for (from, to) in pairs {
        let of_pair = |m: &&crate::recording::LinkMessage| (&*m.from, &*m.to) == (from, to);
        let messages: Vec<_> = links.messages.iter().filter(of_pair).collect();
        let delays: Vec<f64> = messages
            .iter()
            .filter_map(|m| m.t_received_s.map(|t_s| t_s - m.t_sent_s))
            .collect();
        let early = delays.iter().filter(|delay| **delay < 0.0).count();
        let lost = messages.len() - delays.len();
        if early > 0 {
            let statement = format!(
                "{early} of {} messages from {from} arrive before they were sent",
                messages.len()
            );
            let remedy = "put both robots on one clock";
            findings.push(Finding::new(
                Severity::Error,
                to,
                "negative_latency",
                statement,
                remedy,
            ));
        }
        let median_s = median(delays).unwrap_or(f64::NAN);
        let statement = format!(
            "{} messages from {from}: median latency {median_s:.4} s, {lost} lost",
            messages.len()
        );
        findings.push(Finding::new(
            Severity::Note,
            to,
            "link",
            statement,
            "nothing to do",
        ));
        if recording.robots.iter().all(|robot| robot.name != from) {
            let statement = format!("messages come from {from}, which has no folder");
            let remedy = "spell names in links.csv as the folders";
            findings.push(Finding::new(
                Severity::Warning,
                to,
                "unknown_sender",
                statement,
                remedy,
            ));
        }
    }
}
