//! Sources that stand still: a robot that does not move, a wheel whose column never changes, a reference that lost
//! itself.

use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::combine;
use crate::rows::{RobotRows, Rows};
use crate::table::StreamKind;

/// A wheel moves in a window if it turns faster than this share of its fastest.
const MOVING_SHARE: f64 = 0.2;
/// So many windows in a row are no coincidence (two seconds), and one in so many of the recording: streams need not
/// begin and end together.
const WINDOWS: usize = 4;
const ONE_IN: usize = 20;
/// A robot that turned by more (rad) and drove further (m) changes both axes and its heading.
const TURNS_RAD: f64 = 1.0;
const DRIVES_M: f64 = 0.1;
/// A robot that stays within this (m, rad) of noise over the whole recording does not drive.
const STAYS_M_S: f64 = 0.02;
const STAYS_RAD_S: f64 = 0.05;

/// Adds findings about what stands still. `window_s` is the length of the windows.
pub(super) fn check(
    robot: &RobotRows<'_>,
    windows: &Windows,
    window_s: f64,
    findings: &mut Vec<Finding>,
) {
    let name = &robot.robot.name;
    let mut add = |severity, id, statement: String, remedy: &str| {
        findings.push(Finding::new(severity, name, id, statement, remedy));
    };
    if nothing_moves(windows) {
        let statement = "nothing moves: wheels, poses and gyro stand still, so nothing about the motion can be judged";
        add(
            Severity::Warning,
            "nothing_moves",
            statement.to_owned(),
            "record a drive with straights and turns",
        );
        return;
    }
    if let Some(side) = still_wheel(windows) {
        let other = if side == "right" { "left" } else { "right" };
        let (severity, why) = if pose_turns(windows, side) {
            let why = "by the pose it turns as well, so its encoder is not read";
            (Severity::Error, why)
        } else {
            let why = "its encoder is not read, or it stands all the time";
            (Severity::Warning, why)
        };
        let statement =
            format!("the {side} wheel never changes while the {other} one turns: {why}");
        let remedy = "look at that encoder and its cable, and record again";
        add(severity, "wheel_never_changes", statement, remedy);
    }
    if let Some(axis) = robot.stream(StreamKind::Pose).and_then(still_axis) {
        let statement = format!(
            "{axis} of the pose never changes, although the robot turns and drives: it is not measured"
        );
        let remedy = "look at what writes it, and at the map of columns or topics";
        add(Severity::Error, "position_never_changes", statement, remedy);
    }
    let lost_s = lost(windows, window_s);
    if let Some([from_s, to_s]) = lost_s.first() {
        let total_s: f64 = lost_s.iter().map(|[from_s, to_s]| to_s - from_s).sum();
        let further = match lost_s.len() {
            1 => String::new(),
            count => format!(" and {} times more, {total_s:.1} s in all", count - 1),
        };
        let statement = format!(
            "the pose stays at one value or is missing while the wheels turn, from {from_s:.1} s to {to_s:.1} s{further}: \
             the reference lost itself, and says nothing about that time"
        );
        let remedy = "the diagnosis leaves these poses out; look for what the reference lost there";
        add(Severity::Warning, "reference_lost", statement, remedy);
    }
}

fn largest(values: &[f64]) -> Option<f64> {
    let known = values.iter().filter(|value| value.is_finite());
    known.map(|value| value.abs()).reduce(f64::max)
}

/// Whether all sources that see the motion say that there is none.
fn nothing_moves(windows: &Windows) -> bool {
    let at_most = |values: &[f64], most: f64| largest(values).map(|most_seen| most_seen <= most);
    let seen = [
        at_most(&windows.wheel_right, 0.0),
        at_most(&windows.wheel_left, 0.0),
        at_most(&windows.pose_v, STAYS_M_S),
        at_most(&windows.pose_w, STAYS_RAD_S),
        at_most(&windows.odometry_v, STAYS_M_S),
        at_most(&windows.gyro_w, STAYS_RAD_S),
    ];
    let seen: Vec<bool> = seen.into_iter().flatten().collect();
    !seen.is_empty() && seen.iter().all(|still| *still)
}

/// The side of a wheel whose column has one value, while the other one's has many.
fn still_wheel(windows: &Windows) -> Option<&'static str> {
    let right = largest(&windows.wheel_right)?;
    let left = largest(&windows.wheel_left)?;
    match (right == 0.0, left == 0.0) {
        (true, false) => Some("right"),
        (false, true) => Some("left"),
        _ => None,
    }
}

/// Whether the pose tells that the wheel of this side turns, at a speed (rad/s) that is a share of the other one's.
fn pose_turns(windows: &Windows, side: &str) -> bool {
    let Some([r, b]) = windows.size_m else {
        return false;
    };
    let (sign, other) = match side {
        "right" => (1.0, &windows.wheel_left),
        _ => (-1.0, &windows.wheel_right),
    };
    let turns = combine(&windows.pose_v, &windows.pose_w, |v, w| {
        (v + sign * b * w) / r
    });
    let size = |speeds: &[f64]| {
        let known: Vec<f64> = speeds
            .iter()
            .filter(|s| s.is_finite())
            .map(|s| s.abs())
            .collect();
        known.iter().sum::<f64>() / known.len().max(1) as f64
    };
    size(&turns) > MOVING_SHARE * size(other)
}

/// The finding about a heading that was not measured.
pub(super) fn heading(name: &str, windows: &Windows, window_s: f64) -> Option<Finding> {
    let statement = "the heading of the pose never changes while the wheels turn the robot: it is not measured, and the \
                     diagnosis reads the positions alone";
    let remedy = "leave the heading out, or write the one that was measured";
    let id = "heading_never_changes";
    has_no_heading(windows, window_s)
        .then(|| Finding::new(Severity::Warning, name, id, statement, remedy))
}

/// Whether the heading has one value although the wheels turn the robot and it drives.
fn has_no_heading(windows: &Windows, window_s: f64) -> bool {
    let (_, turning) = windows.wheel_twist();
    let (mut turned_rad, mut span) = (0.0, [0.0_f64; 2]);
    for w in turning.iter().filter(|w| w.is_finite()) {
        turned_rad += w * window_s;
        span = [span[0].min(turned_rad), span[1].max(turned_rad)];
    }
    let moves = |speeds: &[f64]| speeds.iter().any(|own| own.is_finite() && *own != 0.0);
    let known = windows.pose_w.iter().any(|w| w.is_finite());
    known && !moves(&windows.pose_w) && moves(&windows.pose_v) && span[1] - span[0] > TURNS_RAD
}

/// The axis of the pose that has one value although the other one and the heading change.
fn still_axis(pose: &Rows<'_>) -> Option<&'static str> {
    let mut spans = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    let mut cursor = pose.clone().cursor();
    while let Some(block) = cursor.next_block() {
        for i in 0..block.t_s.len() {
            for (span, name) in spans.iter_mut().zip(["x_m", "y_m", "yaw_rad"]) {
                let value = block.number_named(name, i);
                *span = [span[0].min(value), span[1].max(value)];
            }
        }
    }
    let [x, y, turn] = spans.map(|[low, high]| high - low);
    match (x == 0.0 && y > DRIVES_M, y == 0.0 && x > DRIVES_M) {
        _ if turn < TURNS_RAD => None,
        (true, _) => Some("x"),
        (_, true) => Some("y"),
        _ => None,
    }
}

/// The times in which the pose stays at one value, or is missing, while a wheel turns (s).
pub(super) fn lost(windows: &Windows, window_s: f64) -> Vec<[f64; 2]> {
    let fastest = [&windows.wheel_right, &windows.wheel_left].map(|side| largest(side));
    let [Some(right), Some(left)] = fastest else {
        return Vec::new();
    };
    let limit = MOVING_SHARE * right.max(left);
    let mut found: Vec<[f64; 2]> = Vec::new();
    let moves = |i: usize| {
        let sides = [&windows.wheel_right, &windows.wheel_left];
        let speeds = sides.map(|side| side.get(i).map_or(f64::NAN, |speed| speed.abs()));
        limit > 0.0 && speeds.iter().any(|speed| *speed > limit)
    };
    let least = WINDOWS.max(windows.pose_v.len() / ONE_IN);
    let seen = windows.pose_v.iter().any(|v| v.is_finite() && *v != 0.0);
    if !seen {
        return found;
    }
    let (mut first, mut moving) = (None, 0);
    for i in 0..=windows.pose_v.len() {
        let still = match (windows.pose_v.get(i), windows.pose_w.get(i)) {
            (Some(v), Some(w)) => v.is_nan() || (*v == 0.0 && *w == 0.0),
            _ => false,
        };
        if still && (first.is_some() || moves(i)) {
            first.get_or_insert(i);
            moving += usize::from(moves(i));
        } else if let Some(from) = first.take() {
            let at_s = |i: usize| windows.start_s + i as f64 * window_s;
            if std::mem::take(&mut moving) >= least {
                found.push([at_s(from), at_s(i)]);
            }
        }
    }
    found
}
