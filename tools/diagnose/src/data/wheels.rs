//! Wheel angles from whatever recorded them: ticks, angles, speeds, or the robot's own odometry.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::Robot;

use super::streams::{self, Rows, WheelKind};
use crate::data::wheel_path::{WheelPath, median_interval};

/// Rows that a wheel path needs.
const LEAST_ROWS: usize = 8;
/// Share of rows without motion below which a log holds changes alone.
const STILL_SHARE: f64 = 0.01;
/// A gap of a log of changes: this many median intervals.
pub(super) const GAP: f64 = 4.0;

/// The angles of both wheels, from zero at the first row; times count from `origin_s`. `None` without
/// usable wheels.
pub(crate) fn path(robot: &Robot, model: &RobotModel, origin_s: f64) -> Option<WheelPath> {
    let mut path = WheelPath::default();
    let mut first = None;
    for (t_s, row) in angles(robot, model)? {
        let later = path
            .times_s
            .last()
            .is_none_or(|last| t_s - origin_s > *last);
        if !later {
            continue;
        }
        let zero = *first.get_or_insert(row);
        path.times_s.push(t_s - origin_s);
        path.angles_rad.push([row[0] - zero[0], row[1] - zero[1]]);
    }
    (path.times_s.len() >= LEAST_ROWS).then(|| with_rests(path))
}

/// Angles of both wheels (rad).
fn angles(robot: &Robot, model: &RobotModel) -> Option<Rows<2>> {
    if robot.wheels.is_none() {
        return wheel_speeds(robot, model).map(integrated);
    }
    let wheels = streams::wheels(robot, model)?;
    Some(match wheels.kind {
        WheelKind::Angle => wheels.rows,
        WheelKind::Speed => integrated(wheels.rows),
    })
}

/// Wheel speeds that the robot's own estimate of its velocity stands for (rad/s).
pub(super) fn wheel_speeds(robot: &Robot, model: &RobotModel) -> Option<Rows<2>> {
    let (r, b) = (model.robot.wheel_radius_m, model.robot.half_track_m);
    let rows = streams::odometry(robot)?.into_iter();
    let speeds = rows.map(|(t_s, [v, w])| (t_s, [(v + b * w) / r, (v - b * w) / r]));
    let known = speeds.filter(|(_, speeds)| speeds.iter().all(|s| s.is_finite()));
    Some(known.collect())
}

/// Integral of speeds by the trapezoidal rule.
fn integrated(mut rows: Rows<2>) -> Rows<2> {
    let mut last: Option<(f64, [f64; 2])> = None;
    let mut angles = [0.0; 2];
    for (t_s, row) in &mut rows {
        let speeds = *row;
        if let Some((last_s, last)) = last {
            angles = [0, 1].map(|i| angles[i] + (*t_s - last_s) * (speeds[i] + last[i]) / 2.0);
        }
        *row = angles;
        last = Some((*t_s, speeds));
    }
    rows
}

/// How often (s) a log has a row while the wheels turn, where it has one only when a count changed: what it has no row of at
/// rest has gaps.
pub(crate) fn changes_every_s(robot: &Robot, model: &RobotModel) -> Option<f64> {
    let (times_s, angles_rad) = angles(robot, model)?.into_iter().unzip();
    let path = WheelPath {
        times_s,
        angles_rad,
    };
    let every_s = median_interval(&path.times_s);
    let gaps = path.times_s.windows(2).map(|pair| pair[1] - pair[0]);
    let rests = gaps.fold(0.0, f64::max) > GAP * every_s;
    let changes = path.times_s.len() >= LEAST_ROWS && every_s > 0.0 && holds_changes_alone(&path);
    (changes && rests).then_some(every_s)
}

/// Whether a log has a row only when a count changed.
fn holds_changes_alone(path: &WheelPath) -> bool {
    let pairs = path.angles_rad.windows(2);
    let still = pairs.filter(|pair| pair[0] == pair[1]).count() as f64;
    still < STILL_SHARE * path.times_s.len() as f64
}

/// In a log that has a row only when a count changed, the wheels stand during a gap until one
/// interval before the row that ends it.
fn with_rests(path: WheelPath) -> WheelPath {
    let median_s = median_interval(&path.times_s);
    if !holds_changes_alone(&path) {
        return path;
    }
    let mut rested = WheelPath::default();
    for (row, (t_s, angle)) in path.times_s.iter().zip(&path.angles_rad).enumerate() {
        if row > 0 && t_s - path.times_s[row - 1] > GAP * median_s {
            rested.times_s.push(t_s - median_s);
            rested.angles_rad.push(path.angles_rad[row - 1]);
        }
        rested.times_s.push(*t_s);
        rested.angles_rad.push(*angle);
    }
    rested
}
