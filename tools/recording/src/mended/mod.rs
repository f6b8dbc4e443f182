//! A recording as a diagnosis reads it: with counters that run on, without rows whose stamps or values say nothing.

mod poses;

use std::borrow::Cow;

use slipstream_bus::RobotModel;

use crate::check::{self, BURSTING, Faults, Finding};
use crate::mend::{self, Level, MendedWheels, WheelFaults};
use crate::recording::{Imu, Pose, Recording, Robot, Stream, Wheels};
use crate::rows::{AllRows, RobotRows, Rows};
use crate::table::StreamKind;

/// The recording with what is certain undone, and what was undone. It is the same one where nothing is wrong.
/// `model_of` gives the model of each robot; without one, the model that came with the recording is used.
///
/// [`check()`](crate::check()) says the same of the recording as it is. Reading and writing never alter data.
pub fn mended<'a>(
    recording: &'a Recording,
    model_of: &dyn Fn(&str) -> Option<RobotModel>,
) -> (Cow<'a, Recording>, Vec<Finding>) {
    let mut findings = Vec::new();
    let mut robots = Vec::new();
    for (index, rows) in AllRows::of(recording).robots.iter().enumerate() {
        let model = model_of(&rows.robot.name).or_else(|| recording.model.clone());
        if let Some((robot, found)) = robot(rows, model.as_ref()) {
            robots.push((index, robot));
            findings.extend(found);
        }
    }
    if robots.is_empty() {
        return (Cow::Borrowed(recording), findings);
    }
    let mut whole = recording.clone();
    for (index, robot) in robots {
        if let Some(place) = whole.robots.get_mut(index) {
            *place = robot;
        }
    }
    (Cow::Owned(whole), findings)
}

/// The robot mended, and what was undone; `None` where there is nothing to undo.
fn robot(rows: &RobotRows<'_>, model: Option<&RobotModel>) -> Option<(Robot, Vec<Finding>)> {
    let Faults {
        wheels: faults,
        poses: of_poses,
        of_wheels,
        of_jumps,
        of_heading,
    } = check::faults_of(rows, model);
    let faults = faults.filter(|faults| !faults.is_clean());
    let bursts = check::of_bursts(rows);
    if faults.is_none() && bursts.is_empty() && of_poses.is_clean() && of_heading.is_none() {
        return None;
    }
    let mut robot = rows.robot.clone();
    let mut findings = bursts;
    if let Some(faults) = faults {
        robot.wheels = robot.wheels.map(|wheels| mended_wheels(&wheels, &faults));
        findings.extend(of_wheels);
    }
    if let Some(poses) = &mut robot.pose {
        // of positions alone nobody knows how the frame turned: they stay, and the warning about the recording too
        if poses.values.yaw_rad.is_some() {
            findings.extend(of_jumps);
        }
        let kept = poses::mended(poses, &of_poses);
        keep_rows(poses, &kept);
        keep_poses(&mut poses.values, &kept);
        if of_heading.is_some() {
            poses.values.yaw_rad = None;
        }
        findings.extend(of_heading);
    }
    for kind in BURSTING {
        leave_out_bursts(&mut robot, kind);
    }
    Some((robot, findings))
}

fn mended_wheels(wheels: &Stream<Wheels>, faults: &WheelFaults) -> Stream<Wheels> {
    match faults.level {
        Some(Level::PerRow) => summed(wheels),
        Some(Level::Speed(rad_s)) => Stream {
            values: speeds(&wheels.values, rad_s),
            ..wheels.clone()
        },
        None => undone(wheels, faults),
    }
}

/// The cells of both wheels as numbers.
fn numbers(wheels: &Wheels) -> [Vec<f64>; 2] {
    let of_counts = |cells: &Vec<Option<i64>>| {
        let number = |cell: &Option<i64>| cell.map_or(f64::NAN, |count| count as f64);
        cells.iter().map(number).collect()
    };
    match wheels {
        Wheels::Ticks { right, left } => [of_counts(right), of_counts(left)],
        Wheels::Angle {
            right_rad: right,
            left_rad: left,
        }
        | Wheels::Speed {
            right_rad_s: right,
            left_rad_s: left,
        } => [right.clone(), left.clone()],
    }
}

/// Numbers as cells of the same kind.
fn cells(like: &Wheels, [right, left]: [Vec<f64>; 2]) -> Wheels {
    let count = |value: f64| (!value.is_nan()).then(|| value.round() as i64);
    match like {
        Wheels::Ticks { .. } => Wheels::Ticks {
            right: right.into_iter().map(count).collect(),
            left: left.into_iter().map(count).collect(),
        },
        Wheels::Angle { .. } => Wheels::Angle {
            right_rad: right,
            left_rad: left,
        },
        Wheels::Speed { .. } => Wheels::Speed {
            right_rad_s: right,
            left_rad_s: left,
        },
    }
}

/// Changes per row as a running counter.
fn summed(wheels: &Stream<Wheels>) -> Stream<Wheels> {
    let sums = numbers(&wheels.values).map(|changes| {
        let mut sum = 0.0;
        let next = |change: f64| {
            sum += if change.is_nan() { 0.0 } else { change };
            if change.is_nan() { change } else { sum }
        };
        changes.into_iter().map(next).collect()
    });
    Stream {
        t_s: wheels.t_s.clone(),
        values: cells(&wheels.values, sums),
        unknown: wheels.unknown.clone(),
    }
}

fn speeds(wheels: &Wheels, rad_s: f64) -> Wheels {
    let [right_rad_s, left_rad_s] =
        numbers(wheels).map(|side| side.into_iter().map(|speed| speed * rad_s).collect());
    Wheels::Speed {
        right_rad_s,
        left_rad_s,
    }
}

/// The rows without glitches, wraps and jumps, and of those the longest part in which each step is known.
fn undone(wheels: &Stream<Wheels>, faults: &WheelFaults) -> Stream<Wheels> {
    let [right, left] = numbers(&wheels.values);
    let known = faults.known_rows(wheels.t_s.len());
    let mut rows = MendedWheels::new(faults);
    let (mut kept, mut sides) = (Vec::new(), [Vec::new(), Vec::new()]);
    for (row, (right, left)) in right.iter().zip(&left).enumerate() {
        if let Some(values) = rows.next([*right, *left]).filter(|_| known.contains(&row)) {
            kept.push(row);
            sides
                .iter_mut()
                .zip(values)
                .for_each(|(side, v)| side.push(v));
        }
    }
    let mut mended = Stream {
        t_s: wheels.t_s.clone(),
        values: (),
        unknown: wheels.unknown.clone(),
    };
    keep_rows(&mut mended, &kept);
    Stream {
        t_s: mended.t_s,
        values: cells(&wheels.values, sides),
        unknown: mended.unknown,
    }
}

/// Keeps these rows (ascending) of times and unknown columns.
fn keep_rows<V>(stream: &mut Stream<V>, kept: &[usize]) {
    keep(&mut stream.t_s, kept);
    for column in &mut stream.unknown {
        keep(&mut column.cells, kept);
    }
}

fn keep<T: Clone>(cells: &mut Vec<T>, kept: &[usize]) {
    *cells = kept
        .iter()
        .filter_map(|row| cells.get(*row).cloned())
        .collect();
}

fn leave_out_bursts(robot: &mut Robot, kind: StreamKind) {
    let Some(rows) = Rows::of_robot(robot, kind) else {
        return;
    };
    let (left_out, len) = (mend::bursts(&rows).rows, rows.len());
    if left_out.is_empty() {
        return;
    }
    let kept: Vec<usize> = (0..len)
        .filter(|row| left_out.binary_search(row).is_err())
        .collect();
    match kind {
        StreamKind::Wheels => keep_wheels(robot.wheels.as_mut(), &kept),
        StreamKind::Pose => {
            if let Some(stream) = &mut robot.pose {
                keep_rows(stream, &kept);
                keep_poses(&mut stream.values, &kept);
            }
        }
        StreamKind::Imu => keep_imu(robot.imu.as_mut(), &kept),
        StreamKind::Command | StreamKind::Odometry | StreamKind::Motor => {}
    }
}

fn keep_wheels(stream: Option<&mut Stream<Wheels>>, kept: &[usize]) {
    let Some(stream) = stream else { return };
    keep_rows(stream, kept);
    match &mut stream.values {
        Wheels::Ticks { right, left } => {
            keep(right, kept);
            keep(left, kept);
        }
        Wheels::Angle {
            right_rad: right,
            left_rad: left,
        }
        | Wheels::Speed {
            right_rad_s: right,
            left_rad_s: left,
        } => {
            keep(right, kept);
            keep(left, kept);
        }
    }
}

fn keep_poses(poses: &mut Pose, kept: &[usize]) {
    let Pose { x_m, y_m, yaw_rad } = poses;
    [Some(x_m), Some(y_m), yaw_rad.as_mut()]
        .into_iter()
        .flatten()
        .for_each(|cells| keep(cells, kept));
}

fn keep_imu(stream: Option<&mut Stream<Imu>>, kept: &[usize]) {
    let Some(stream) = stream else { return };
    keep_rows(stream, kept);
    let Imu {
        ax_m_s2,
        ay_m_s2,
        gz_rad_s,
    } = &mut stream.values;
    [ax_m_s2, ay_m_s2, gz_rad_s]
        .into_iter()
        .flatten()
        .for_each(|cells| keep(cells, kept));
}
