//! Wheel angles from whatever recorded them: ticks, angles, speeds, or the robot's own odometry.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::Robot;

use super::wheel_rows::{WheelKind, values};
use crate::data::wheel_path::{WheelPath, median_interval};

/// Rows that a wheel path needs.
const LEAST_ROWS: usize = 8;
/// Share of rows without motion below which a log holds changes alone.
const STILL_SHARE: f64 = 0.01;
/// A gap of a log of changes: this many median intervals.
const GAP: f64 = 4.0;

/// The angles of both wheels, from zero at the first row; times count from `origin_s`. `None` without
/// usable wheels.
pub(crate) fn path(robot: &Robot, model: &RobotModel, origin_s: f64) -> Option<WheelPath> {
    let (times_s, angles) = angles(robot, model)?;
    let mut path = WheelPath::default();
    let mut first = None;
    for (t_s, row) in times_s.iter().zip(angles) {
        let later = path
            .times_s
            .last()
            .is_none_or(|last| t_s - origin_s > *last);
        if !later || row.iter().any(|angle| !angle.is_finite()) {
            continue;
        }
        let zero = *first.get_or_insert(row);
        path.times_s.push(t_s - origin_s);
        path.angles_rad.push([row[0] - zero[0], row[1] - zero[1]]);
    }
    (path.times_s.len() >= LEAST_ROWS).then(|| with_rests(path))
}

/// Times (s) and angles (rad).
fn angles(robot: &Robot, model: &RobotModel) -> Option<(Vec<f64>, Vec<[f64; 2]>)> {
    let Some(stream) = &robot.wheels else {
        return odometry(robot, model);
    };
    let (kind, _, rows) = values(robot, model)?;
    Some(match kind {
        WheelKind::Angle => (stream.t_s.clone(), rows),
        WheelKind::Speed => integrated(&stream.t_s, rows.into_iter()),
    })
}

/// Wheel angles that the robot's own estimate of its velocity stands for.
fn odometry(robot: &Robot, model: &RobotModel) -> Option<(Vec<f64>, Vec<[f64; 2]>)> {
    let stream = robot.odometry.as_ref()?;
    let turn = stream.values.w_rad_s.as_ref()?;
    let (r, b) = (model.robot.wheel_radius_m, model.robot.half_track_m);
    let speeds = stream.values.v_m_s.iter().zip(turn);
    Some(integrated(
        &stream.t_s,
        speeds.map(|(v, w)| [(v + b * w) / r, (v - b * w) / r]),
    ))
}

/// Integral of speeds by the trapezoidal rule; rows without a speed are left out.
fn integrated(
    times_s: &[f64],
    speeds: impl Iterator<Item = [f64; 2]>,
) -> (Vec<f64>, Vec<[f64; 2]>) {
    let mut times = Vec::new();
    let mut angles: Vec<[f64; 2]> = Vec::new();
    let mut last: Option<(f64, [f64; 2])> = None;
    for (t_s, speed) in times_s.iter().zip(speeds) {
        if speed.iter().any(|s| !s.is_finite()) {
            continue;
        }
        let before = angles.last().copied().unwrap_or([0.0; 2]);
        let next = last.map_or(before, |(last_s, last)| {
            [0, 1].map(|i| before[i] + (t_s - last_s) * (speed[i] + last[i]) / 2.0)
        });
        times.push(*t_s);
        angles.push(next);
        last = Some((*t_s, speed));
    }
    (times, angles)
}

/// In a log that has a row only when a count changed, the wheels stand during a gap until one
/// interval before the row that ends it.
fn with_rests(path: WheelPath) -> WheelPath {
    let median_s = median_interval(&path.times_s);
    let pairs = path.angles_rad.windows(2);
    let still = pairs.filter(|pair| pair[0] == pair[1]).count() as f64;
    if still >= STILL_SHARE * path.times_s.len() as f64 {
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
