//! Rows of the wheels beside the commands that turned them.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::Robot;

use super::command::CommandPath;
use super::matched::Stamps;
use super::streams::{self, Rows, WheelKind, Wheels};

/// One row: time (s), both wheels (rad, or rad/s), and whether it is evidence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WheelRow {
    pub(crate) time_s: f64,
    pub(crate) values: [f64; 2],
    pub(crate) counts: bool,
}

/// The rows of a run.
#[derive(Debug, Clone)]
pub(crate) struct WheelRows {
    pub(crate) kind: WheelKind,
    /// Deviation of a rounding to whole counts (rad); 0 where there is none.
    pub(crate) rounding_rad: f64,
    pub(crate) rows: Vec<WheelRow>,
}

/// Rows that a run needs.
const LEAST_ROWS: usize = 30;
/// Most rows of one run.
const MOST_ROWS: usize = 6000;
/// A wheel that turns slower than this share of its top speed under a command of 0 rests.
pub(crate) const REST_SHARE: f64 = 0.02;
/// A wheel that turns faster than this share although its command has been 0 for this long (s) is
/// turned by somebody else.
pub(crate) const AWAY_SHARE: f64 = 0.1;
pub(crate) const AWAY_S: f64 = 1.0;
/// A rest this far from any motion (s) says nothing.
const NEAR_S: f64 = 0.3;
/// Time over which the first speed is measured (s), and how near it is to the first command.
const FIRST_S: f64 = 0.1;
const RUNNING_SHARE: f64 = 0.3;

/// The rows of a robot's wheels that say how they follow `commands`; times count from `origin_s`.
pub(crate) fn rows(
    robot: &Robot,
    model: &RobotModel,
    commands: &CommandPath,
    origin_s: f64,
    excluded_s: &[[f64; 2]],
) -> Option<WheelRows> {
    let Wheels {
        kind,
        rounding_rad,
        rows,
    } = streams::wheels(robot, model)?;
    let mut all: Rows<2> = Vec::new();
    for (stamp_s, value) in rows {
        let excluded = excluded_s.iter().any(|[a, b]| (*a..=*b).contains(&stamp_s));
        let t_s = stamp_s - origin_s;
        let later = all.last().is_none_or(|(last, _)| t_s > *last);
        if later && !excluded {
            all.push((t_s, value));
        }
    }
    if kind == WheelKind::Angle {
        let stride = all.len().div_ceil(MOST_ROWS).max(1);
        all = all.into_iter().step_by(stride).collect();
    } else {
        all.truncate(MOST_ROWS);
    }
    let mut rows = kept(&all, kind, commands);
    if commands.by_volts {
        // a motor that rests says what it bears
        rows.iter_mut().for_each(|row| row.counts = true);
    }
    (rows.len() >= LEAST_ROWS).then_some(WheelRows {
        kind,
        rounding_rad: rounding_rad.unwrap_or(0.0),
        rows,
    })
}

/// Keeps of two recordings the rows that both have; `false` where these are too few.
pub(crate) fn match_wheels(stamps: &Stamps, [first, second]: [&mut WheelRows; 2]) -> bool {
    let kept = stamps.keep([&mut first.rows, &mut second.rows], |row| row.time_s);
    if kept {
        for (a, b) in first.rows.iter_mut().zip(&mut second.rows) {
            let counts = a.counts && b.counts;
            (a.counts, b.counts) = (counts, counts);
        }
    }
    kept
}

/// Size of each wheel's speed at each row (rad/s).
fn sizes(all: &[(f64, [f64; 2])], kind: WheelKind) -> Vec<[f64; 2]> {
    if kind == WheelKind::Speed {
        return all.iter().map(|(_, v)| v.map(f64::abs)).collect();
    }
    let mut sizes = vec![[0.0; 2]];
    sizes.extend(all.windows(2).map(|pair| {
        let h = pair[1].0 - pair[0].0;
        [0, 1].map(|i| (pair[1].1[i] - pair[0].1[i]).abs() / h)
    }));
    sizes
}

/// Rows near a motion, with whether each is evidence.
fn kept(all: &[(f64, [f64; 2])], kind: WheelKind, commands: &CommandPath) -> Vec<WheelRow> {
    let sizes = sizes(all, kind);
    let mut active = vec![false; all.len()];
    for wheel in 0..2 {
        let mut sorted: Vec<f64> = sizes.iter().map(|s| s[wheel]).collect();
        sorted.sort_by(f64::total_cmp);
        let top = sorted.get(sorted.len() * 98 / 100).copied().unwrap_or(0.0) + 1e-9;
        let (mut told_s, mut away_s) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for (row, (t_s, _)) in all.iter().enumerate() {
            let command = commands.at(*t_s).map_or(0.0, |u| u[wheel]);
            let speed = sizes[row][wheel];
            let still = command.abs() < 1e-9;
            if !still {
                told_s = *t_s;
            }
            if still && t_s - told_s > AWAY_S && speed > AWAY_SHARE * top {
                away_s = *t_s;
            }
            let rests = still && speed < REST_SHARE * top;
            active[row] |= !rests && t_s - away_s >= AWAY_S;
        }
    }
    let times: Vec<f64> = all
        .iter()
        .zip(&active)
        .filter(|(_, active)| **active)
        .map(|(row, _)| row.0)
        .collect();
    let near = |t_s: f64| {
        let next = times.partition_point(|other| *other < t_s);
        let around = [next.checked_sub(1), Some(next)];
        let mut found = around.into_iter().flatten().filter_map(|i| times.get(i));
        found.any(|other| (other - t_s).abs() < NEAR_S)
    };
    all.iter()
        .zip(active)
        .filter(|((t_s, _), _)| near(*t_s))
        .map(|(&(time_s, values), counts)| WheelRow {
            time_s,
            values,
            counts,
        })
        .collect()
}

/// Whether the wheels turn at the speed of the first command from the first row on.
pub(crate) fn is_running(wheels: &WheelRows, commands: &CommandPath) -> bool {
    let Some(first) = wheels.rows.first() else {
        return false;
    };
    let later = wheels
        .rows
        .iter()
        .find(|row| row.time_s >= first.time_s + FIRST_S);
    let Some(later) = later else { return false };
    let command = commands.speeds_rad_s[0];
    (0..2).all(|i| {
        let speed = match wheels.kind {
            WheelKind::Angle => (later.values[i] - first.values[i]) / (later.time_s - first.time_s),
            WheelKind::Speed => first.values[i],
        };
        (speed - command[i]).abs() <= RUNNING_SHARE * command[i].abs()
    }) && command.iter().any(|u| u.abs() > 1e-9)
        && first.time_s < commands.times_s[0] + FIRST_S
}
