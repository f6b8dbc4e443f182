//! The motion of a robot according to each source, over time windows.
//!
//! Wheel angles and poses enter as differences over a window, so that their noise averages out; rates
//! enter as means of the rows in a window. A source without data in a window is NaN there.

use std::borrow::Cow;
use std::f64::consts::TAU;

use slipstream_bus::RobotModel;

use super::resample::{Interpolation, Means, rates};
use super::similarity::combine;
use crate::mend::{Level, MendedWheels, WheelFaults};
use crate::recording::Unwrap;
use crate::rows::{RobotRows, Rows};
use crate::table::{StreamKind, Table};

/// Shortest window of [`window_s`] (s).
const MIN_WINDOW_S: f64 = 0.5;
/// Largest number of windows.
const MAX_WINDOWS: f64 = 20_000.0;
/// A window has a direction of motion if it moves faster than this share of the fastest window.
const MOVING_SHARE: f64 = 0.2;

/// The motion according to each source, one value per window. A list is empty without its source.
#[derive(Debug, Default)]
pub(super) struct Windows {
    /// Pose: forward speed (m/s).
    pub(super) pose_v: Vec<f64>,
    /// Pose: yaw rate (rad/s).
    pub(super) pose_w: Vec<f64>,
    /// Right wheel: speed (rad/s, or counts/s if the counts per revolution are unknown).
    pub(super) wheel_right: Vec<f64>,
    /// Left wheel: speed, in the same unit.
    pub(super) wheel_left: Vec<f64>,
    /// Mean of the right and left wheel's column of angles or counts, as it is written; empty for speeds.
    pub(super) levels: [Vec<f64>; 2],
    /// Angle of a count (rad), if known.
    pub(super) rad_per_count: Option<f64>,
    /// Start of the first window (s).
    pub(super) start_s: f64,
    /// Gyro: yaw rate (rad/s).
    pub(super) gyro_w: Vec<f64>,
    /// Odometry: forward speed (m/s).
    pub(super) odometry_v: Vec<f64>,
    /// Command: forward speed (m/s).
    pub(super) command_v: Vec<f64>,
    /// Command: yaw rate (rad/s).
    pub(super) command_w: Vec<f64>,
    /// Command: speed of the right wheel (rad/s).
    pub(super) command_right: Vec<f64>,
    /// Command: speed of the left wheel (rad/s).
    pub(super) command_left: Vec<f64>,
    /// Command: torque (N m) or voltage (V) of the right wheel.
    pub(super) drive_right: Vec<f64>,
    /// Command: torque (N m) or voltage (V) of the left wheel.
    pub(super) drive_left: Vec<f64>,
    /// Whether the wheel speeds are in rad/s.
    pub(super) wheels_in_rad: bool,
    /// Wheel radius r (m) and half track b (m), if a model gives them.
    pub(super) size_m: Option<[f64; 2]>,
    /// Pose: number of steps of about 360 between the headings of two rows.
    pub(super) yaw_jumps: usize,
    /// Pose: largest heading, with or without jumps of whole turns; 0 without headings.
    pub(super) largest_yaw: f64,
    /// Pose: cosine of the angle between heading and direction of motion, with the yaw read as
    /// radians and as degrees. NaN in windows with little motion.
    pub(super) heading_cos: [Vec<f64>; 2],
}

impl Windows {
    /// Takes the speeds of the wheels from the values of their columns, which are no angles.
    pub(super) fn read_levels(&mut self, level: Level, interval_s: f64) {
        let (factor, in_rad) = match level {
            Level::PerRow => {
                let rad = self.rad_per_count.filter(|_| self.wheels_in_rad);
                (rad.unwrap_or(1.0) / interval_s, self.wheels_in_rad)
            }
            Level::Speed(rad_s) => (rad_s, true),
        };
        self.wheels_in_rad = in_rad;
        let speeds = |values: &Vec<f64>| values.iter().map(|value| value * factor).collect();
        [self.wheel_right, self.wheel_left] = self.levels.each_ref().map(speeds);
    }

    /// Adds the windows of another run of the machine behind these. A source that one of both does not have is NaN
    /// there.
    pub(super) fn append(&mut self, mut other: Windows) {
        let longest = |all: &mut [&mut Vec<f64>]| all.iter().map(|own| own.len()).max();
        let [before, behind] = [&mut *self, &mut other].map(|own| longest(&mut own.motions()));
        let (before, behind) = (before.unwrap_or(0), behind.unwrap_or(0));
        for (own, next) in self.motions().into_iter().zip(other.motions()) {
            own.resize(before, f64::NAN);
            next.resize(behind, f64::NAN);
            own.append(next);
        }
    }

    /// Everything of which there is one value per window.
    fn motions(&mut self) -> [&mut Vec<f64>; 12] {
        [
            &mut self.pose_v,
            &mut self.pose_w,
            &mut self.wheel_right,
            &mut self.wheel_left,
            &mut self.gyro_w,
            &mut self.odometry_v,
            &mut self.command_v,
            &mut self.command_w,
            &mut self.command_right,
            &mut self.command_left,
            &mut self.drive_right,
            &mut self.drive_left,
        ]
    }

    /// Forward speed (m/s) and yaw rate (rad/s) according to the wheels; empty if the size of the
    /// robot or the counts per revolution are unknown.
    pub(super) fn wheel_twist(&self) -> (Vec<f64>, Vec<f64>) {
        let Some([r, b]) = self.size_m.filter(|_| self.wheels_in_rad) else {
            return (Vec::new(), Vec::new());
        };
        let (right, left) = (&self.wheel_right, &self.wheel_left);
        (
            combine(right, left, |right, left| r * (right + left) / 2.0),
            combine(right, left, |right, left| r * (right - left) / (2.0 * b)),
        )
    }
}

/// Length of the windows over which sources are compared (s): half a second; longer for very long
/// recordings.
pub(super) fn window_s(robot: &RobotRows<'_>) -> f64 {
    let duration_s = span(robot).map_or(0.0, |[start, end]| end - start);
    MIN_WINDOW_S.max(duration_s / MAX_WINDOWS)
}

/// The motion over windows of each of these lengths (s). Reads every stream once. What is wrong with the wheels'
/// columns is undone first.
pub(super) fn windows<const N: usize>(
    robot: &RobotRows<'_>,
    model: Option<&RobotModel>,
    lengths_s: [f64; N],
    faults: Option<&WheelFaults>,
) -> [Windows; N] {
    let grids = lengths_s.map(|length_s| WindowGrid::new(span(robot), length_s));
    let mut windows = lengths_s.map(|_| Windows {
        size_m: model.map(|model| [model.robot.wheel_radius_m, model.robot.half_track_m]),
        start_s: span(robot).map_or(0.0, |[start, _]| start),
        ..Windows::default()
    });
    if let Some(pose) = robot.stream(StreamKind::Pose) {
        add_pose(pose, &grids, &mut windows);
    }
    if let Some(wheels) = robot.stream(StreamKind::Wheels) {
        let counts_per_rev = robot.robot.counts_per_rev(model);
        add_wheels(wheels, counts_per_rev, faults, &grids, &mut windows);
    }
    if let Some(imu) = robot
        .stream(StreamKind::Imu)
        .filter(|imu| imu.has("gz_rad_s"))
    {
        for (windows, [gyro]) in windows.iter_mut().zip(means(imu, ["gz_rad_s"], &grids)) {
            windows.gyro_w = gyro;
        }
    }
    if let Some(odometry) = robot.stream(StreamKind::Odometry) {
        for (windows, [v]) in windows.iter_mut().zip(means(odometry, ["v_m_s"], &grids)) {
            windows.odometry_v = v;
        }
    }
    if let Some(command) = robot.stream(StreamKind::Command) {
        add_command(command, &grids, &mut windows);
    }
    windows
}

/// First and last time (s) of the streams that describe the motion.
pub(super) fn span(robot: &RobotRows<'_>) -> Option<[f64; 2]> {
    let streams = robot.streams.iter();
    let of_motion = streams.filter(|(kind, _)| *kind != StreamKind::Motor);
    of_motion
        .filter_map(|(_, rows)| rows.span_s())
        .reduce(|[start, end], [first, last]| [start.min(first), end.max(last)])
}

/// The times of windows of one length (s).
struct WindowGrid {
    /// Over the whole recording, but at most [`MAX_WINDOWS`] windows.
    edges: Vec<f64>,
    middles: Vec<f64>,
}

impl WindowGrid {
    fn new(span: Option<[f64; 2]>, window_s: f64) -> Self {
        let edges: Vec<f64> = match span.filter(|[start, end]| end > start) {
            Some([start, end]) => {
                let count = ((end - start) / window_s).floor().min(MAX_WINDOWS) as usize;
                (0..=count).map(|i| start + i as f64 * window_s).collect()
            }
            None => Vec::new(),
        };
        let pairs = edges.iter().zip(edges.iter().skip(1));
        Self {
            middles: pairs.map(|(start, end)| (start + end) / 2.0).collect(),
            edges,
        }
    }
}

/// The means of these columns over the windows of each grid.
fn means<const C: usize, const N: usize>(
    rows: &Rows<'_>,
    columns: [&str; C],
    grids: &[WindowGrid; N],
) -> [[Vec<f64>; C]; N] {
    let mut all = grids
        .each_ref()
        .map(|grid| columns.map(|_| Means::new(&grid.edges)));
    let mut cursor = rows.clone().cursor();
    while let Some(block) = cursor.next_block() {
        for (column, mean) in all.iter_mut().flat_map(|set| columns.iter().zip(set)) {
            mean.push(&block.t_s, block.numbers_of(column));
        }
    }
    all.map(|means| means.map(Means::finish))
}

/// What the wheels' columns of angles or counts show over the windows of a grid.
struct WheelsAt<'a> {
    grid: &'a WindowGrid,
    at_edges: [Interpolation<'a>; 2],
    levels: [Means<'a>; 2],
}

/// Adds rates of change, with faults undone and a count taken as `per_count`, and the values as they are written.
fn add_angles<const N: usize>(
    rows: &Rows<'_>,
    faults: &WheelFaults,
    per_count: f64,
    grids: &[WindowGrid; N],
    windows: &mut [Windows; N],
) {
    let mut all = grids.each_ref().map(|grid| WheelsAt {
        grid,
        at_edges: [(); 2].map(|()| Interpolation::new(&grid.edges)),
        levels: [(); 2].map(|()| Means::new(&grid.edges)),
    });
    let mut mended = MendedWheels::new(faults);
    let mut cursor = rows.clone().cursor();
    while let Some(block) = cursor.next_block() {
        let (times, mut sides) = mended.block(block);
        sides
            .iter_mut()
            .flatten()
            .for_each(|angle| *angle *= per_count);
        let written = faults.names.map(|name| numbers(block, name));
        for at in &mut all {
            for i in 0..2 {
                at.at_edges[i].push(&times, &sides[i]);
                at.levels[i].push(&block.t_s, &written[i]);
            }
        }
    }
    for (windows, at) in windows.iter_mut().zip(all) {
        let edges = &at.grid.edges;
        [windows.wheel_right, windows.wheel_left] =
            at.at_edges.map(|at| rates(edges, &at.finish()));
        windows.levels = at.levels.map(Means::finish);
    }
}

/// The cells of a column of numbers or counts.
fn numbers<'a>(block: &'a Table, column: &str) -> Cow<'a, [f64]> {
    let counts = block.counts_of(column);
    if counts.is_empty() {
        return Cow::Borrowed(block.numbers_of(column));
    }
    let number = |count: &Option<i64>| count.map_or(f64::NAN, |count| count as f64);
    Cow::Owned(counts.iter().map(number).collect())
}

/// A pose, resampled to one grid.
struct PoseAt<'a> {
    grid: &'a WindowGrid,
    x: Interpolation<'a>,
    y: Interpolation<'a>,
    /// Without jumps of whole turns, at the edges and in the middle of the windows.
    yaw: [Interpolation<'a>; 2],
}

fn add_pose<const N: usize>(pose: &Rows<'_>, grids: &[WindowGrid; N], windows: &mut [Windows; N]) {
    if !pose.has("yaw_rad") {
        return;
    }
    let mut all = grids.each_ref().map(|grid| PoseAt {
        grid,
        x: Interpolation::new(&grid.edges),
        y: Interpolation::new(&grid.edges),
        yaw: [&grid.edges, &grid.middles].map(|times| Interpolation::new(times)),
    });
    let mut yaws = Yaws::default();
    let mut cursor = pose.clone().cursor();
    while let Some(block) = cursor.next_block() {
        let unwrapped = yaws.push(block.numbers_of("yaw_rad"));
        for at in &mut all {
            at.x.push(&block.t_s, block.numbers_of("x_m"));
            at.y.push(&block.t_s, block.numbers_of("y_m"));
            at.yaw
                .iter_mut()
                .for_each(|yaw| yaw.push(&block.t_s, &unwrapped));
        }
    }
    for (windows, at) in windows.iter_mut().zip(all) {
        (windows.yaw_jumps, windows.largest_yaw) = (yaws.jumps, yaws.largest);
        at.finish(windows);
    }
}

impl PoseAt<'_> {
    fn finish(self, windows: &mut Windows) {
        let edges = &self.grid.edges;
        let [vx, vy] = [self.x, self.y].map(|at| rates(edges, &at.finish()));
        let [at_edges, headings] = self.yaw.map(Interpolation::finish);
        windows.pose_w = rates(edges, &at_edges);
        let along = |heading: f64, (x, y): (&f64, &f64)| x * heading.cos() + y * heading.sin();
        let velocities = || vx.iter().zip(&vy);
        windows.pose_v = headings
            .iter()
            .zip(velocities())
            .map(|(heading, v)| along(*heading, v))
            .collect();
        let fastest = velocities().map(|(x, y)| x.hypot(*y)).fold(0.0, f64::max);
        for (cosines, unit) in windows.heading_cos.iter_mut().zip([1.0, TAU / 360.0]) {
            *cosines = headings
                .iter()
                .zip(velocities())
                .map(|(heading, (x, y))| {
                    let speed = x.hypot(*y);
                    if speed > MOVING_SHARE * fastest {
                        along(heading * unit, (x, y)) / speed
                    } else {
                        f64::NAN
                    }
                })
                .collect();
        }
    }
}

/// What a column of headings shows about its unit.
#[derive(Default)]
struct Yaws {
    unwrap: Unwrap,
    last: Option<f64>,
    /// Steps of about 360 between two rows.
    jumps: usize,
    /// Largest size, with and without jumps of whole turns.
    largest: f64,
}

impl Yaws {
    /// Takes the next rows and returns them without jumps of whole turns.
    fn push(&mut self, yaws: &[f64]) -> Vec<f64> {
        let next = |yaw: &f64| {
            let step = self.last.replace(*yaw).map(|last| (yaw - last).abs());
            let is_jump = step.is_some_and(|step| (350.0..370.0).contains(&step));
            self.jumps += usize::from(is_jump);
            let unwrapped = self.unwrap.next(*yaw);
            self.largest = self.largest.max(unwrapped.abs()).max(yaw.abs());
            unwrapped
        };
        yaws.iter().map(next).collect()
    }
}

fn add_wheels<const N: usize>(
    wheels: &Rows<'_>,
    counts_per_rev: Option<f64>,
    faults: Option<&WheelFaults>,
    grids: &[WindowGrid; N],
    windows: &mut [Windows; N],
) {
    let rad_per_count = counts_per_rev.map(|counts| TAU / counts);
    let Some(faults) = faults else {
        let pairs = means(wheels, ["speed_right_rad_s", "speed_left_rad_s"], grids);
        for (windows, [right, left]) in windows.iter_mut().zip(pairs) {
            windows.wheels_in_rad = true;
            (windows.wheel_right, windows.wheel_left) = (right, left);
        }
        return;
    };
    for windows in windows.iter_mut() {
        windows.wheels_in_rad = rad_per_count.is_some() || !faults.counts;
        windows.rad_per_count = rad_per_count;
    }
    let per_count = rad_per_count.filter(|_| faults.counts).unwrap_or(1.0);
    add_angles(wheels, faults, per_count, grids, windows);
}

fn add_command<const N: usize>(
    command: &Rows<'_>,
    grids: &[WindowGrid; N],
    windows: &mut [Windows; N],
) {
    let [(first, _), (second, _)] = command.empty().columns.as_slice() else {
        return;
    };
    for (windows, [a, b]) in windows
        .iter_mut()
        .zip(means(command, [first, second], grids))
    {
        let (of_first, of_second) = match *first {
            "v_m_s" => (&mut windows.command_v, &mut windows.command_w),
            "speed_right_rad_s" => (&mut windows.command_right, &mut windows.command_left),
            _ => (&mut windows.drive_right, &mut windows.drive_left),
        };
        (*of_first, *of_second) = (a, b);
    }
}
