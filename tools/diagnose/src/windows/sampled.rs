//! The motion of a robot at one moment.

use crate::windows::bench::Bench;
use crate::windows::simulate::asked;
use crate::windows::track::{Sensor, Series, Track};
use crate::windows::window::range;

/// The motion at one moment, as it was measured, or as it was told where wheels turn as they are
/// told.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sampled {
    pub(crate) t_s: f64,
    /// Forward speed (m/s) and yaw rate (rad/s).
    pub(crate) v: f64,
    pub(crate) w: f64,
    /// Wheel angles since the recording began (rad).
    pub(crate) angle: [f64; 2],
    /// x and y (m) and heading (rad): without a camera, where wheels took the robot since the recording
    /// began; NaN without either.
    pub(crate) pose: [f64; 3],
    /// What is commanded at each wheel.
    pub(crate) asked: [f64; 2],
    /// How long the robot has stood (s), until shortly after it has set off.
    pub(crate) rested_s: f64,
}

/// Half of the time over which speeds are taken (s).
pub(crate) const ABOUT_S: f64 = 0.06;

/// What is shorter is no rest, and how long after one the robot is still setting off (s).
const REST_S: f64 = 0.1;
const SETS_OFF_S: f64 = 0.3;

/// Whether a speed (m/s, rad/s) is none that a force could act against.
pub(crate) fn is_still(speed: f64) -> bool {
    speed.abs() < 2e-3
}

impl Sampled {
    /// Whether the robot neither drives nor turns.
    pub(crate) fn stands(&self) -> bool {
        is_still(self.v) && is_still(self.w)
    }

    /// The motion at `t_s`. `otherwise` is the pose (m, m, rad) where no camera shows it, its heading also
    /// where a camera shows none.
    pub(crate) fn new(bench: &Bench, track: &Track, t_s: f64, otherwise: [f64; 3]) -> Self {
        let body = &bench.model.robot;
        let [r, b] = [body.wheel_radius_m, body.half_track_m];
        let wheels = track.of(Sensor::WheelAngle);
        let poses = track.of(Sensor::Pose);
        let angle = wheels.map_or([f64::NAN; 3], |wheels| at(wheels, t_s));
        let mut pose = poses.map_or(otherwise, |poses| at(poses, t_s));
        if !pose[2].is_finite() {
            pose[2] = otherwise[2];
        }
        let [first, _] = range(&track.commands, t_s + 1e-9, t_s + 1e-9);
        let command = &track.commands[first.saturating_sub(1)].1;
        let asked = asked(command, r, b);
        let rolls =
            |[right, left]: [f64; 2]| (r * (right + left) / 2.0, r * (right - left) / (2.0 * b));
        let (v, w) = match wheels {
            // wheels that turn as they are told
            _ if bench.lacks_motion() => rolls(asked),
            Some(wheels) => {
                let [right, left, _] = rate(wheels, t_s, ABOUT_S);
                rolls([right, left])
            }
            None => poses.map_or((0.0, 0.0), |poses| {
                let [dx, dy, turn] = rate(poses, t_s, 2.0 * ABOUT_S);
                (dx * pose[2].cos() + dy * pose[2].sin(), turn)
            }),
        };
        Self {
            t_s,
            v,
            w,
            angle: [angle[0], angle[1]],
            pose,
            asked,
            rested_s: wheels.map_or(f64::NAN, |wheels| rested_s(wheels, t_s)),
        }
    }
}

/// Values of a series between its rows.
fn at(series: &Series, t_s: f64) -> [f64; 3] {
    let next = series.rows.partition_point(|(stamp_s, _)| *stamp_s < t_s);
    let (before, after) = (next.saturating_sub(1), next.min(series.rows.len() - 1));
    let ((a_s, a), (b_s, b)) = (series.rows[before], series.rows[after]);
    let share = if b_s > a_s {
        ((t_s - a_s) / (b_s - a_s)).clamp(0.0, 1.0)
    } else {
        0.0
    };
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * share)
}

/// How fast the values of a series change around `t_s`, over `about_s` to both sides.
pub(crate) fn rate(series: &Series, t_s: f64, about_s: f64) -> [f64; 3] {
    let (a, b) = (at(series, t_s - about_s), at(series, t_s + about_s));
    [0, 1, 2].map(|i| (b[i] - a[i]) / (2.0 * about_s))
}

/// Length of the rest at `t_s`, or of one that ended shortly before (s).
fn rested_s(wheels: &Series, t_s: f64) -> f64 {
    let rows = &wheels.rows;
    let end = rows.partition_point(|(stamp_s, _)| *stamp_s < t_s);
    let stands = |i: &usize| rows[*i].1[..2] == rows[i - 1].1[..2];
    let recent = |i: &usize| t_s - rows[*i].0 < SETS_OFF_S;
    let Some(last) = (1..end).rev().take_while(recent).find(stands) else {
        return 0.0;
    };
    let first = (1..=last).rev().take_while(stands).last().unwrap_or(last);
    let length = rows[last].0 - rows[first - 1].0;
    if length > REST_S { length } else { 0.0 }
}
