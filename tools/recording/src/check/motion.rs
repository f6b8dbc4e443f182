//! The motion of a robot according to each source, over time windows.
//!
//! Wheel angles and poses enter as differences over a window, so that their noise averages out; rates
//! enter as means of the rows in a window. A source without data in a window is NaN there.

use std::f64::consts::TAU;

use slipstream_bus::RobotModel;

use super::resample::{interpolate, means, rates};
use super::similarity::combine;
use crate::recording::{Command, Pose, Robot, Stream, Wheels, unwrap_angles};

/// Shortest window of [`windows`] (s).
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
    /// Pose: cosine of the angle between heading and direction of motion, with the yaw read as
    /// radians and as degrees. NaN in windows with little motion.
    pub(super) heading_cos: [Vec<f64>; 2],
}

impl Windows {
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

/// The motion over windows of half a second; longer ones for very long recordings.
pub(super) fn windows(robot: &Robot, model: Option<&RobotModel>) -> Windows {
    let duration_s = span(robot).map_or(0.0, |[start, end]| end - start);
    windows_of(robot, model, MIN_WINDOW_S.max(duration_s / MAX_WINDOWS))
}

/// The motion over windows of this length (s).
pub(super) fn windows_of(robot: &Robot, model: Option<&RobotModel>, window_s: f64) -> Windows {
    let edges = edges(robot, window_s);
    let mut windows = Windows {
        size_m: model.map(|model| [model.robot.wheel_radius_m, model.robot.half_track_m]),
        ..Windows::default()
    };
    if let Some(pose) = &robot.pose {
        add_pose(pose, &edges, &mut windows);
    }
    if let Some(wheels) = &robot.wheels {
        add_wheels(wheels, robot.counts_per_rev(model), &edges, &mut windows);
    }
    if let Some(imu) = &robot.imu
        && let Some(gz) = &imu.values.gz_rad_s
    {
        windows.gyro_w = means(&imu.t_s, gz, &edges);
    }
    if let Some(odometry) = &robot.odometry {
        windows.odometry_v = means(&odometry.t_s, &odometry.values.v_m_s, &edges);
    }
    if let Some(command) = &robot.command {
        add_command(command, &edges, &mut windows);
    }
    windows
}

/// First and last time (s) of the streams that describe the motion.
fn span(robot: &Robot) -> Option<[f64; 2]> {
    let times = [
        robot.pose.as_ref().map(|s| &s.t_s),
        robot.wheels.as_ref().map(|s| &s.t_s),
        robot.imu.as_ref().map(|s| &s.t_s),
        robot.odometry.as_ref().map(|s| &s.t_s),
        robot.command.as_ref().map(|s| &s.t_s),
    ];
    let streams = || times.iter().copied().flatten();
    let start = streams()
        .filter_map(|t_s| t_s.first().copied())
        .reduce(f64::min)?;
    let end = streams()
        .filter_map(|t_s| t_s.last().copied())
        .reduce(f64::max)?;
    Some([start, end])
}

/// The edges of the windows (s), over the whole recording but at most [`MAX_WINDOWS`] windows.
fn edges(robot: &Robot, window_s: f64) -> Vec<f64> {
    let Some([start, end]) = span(robot).filter(|[start, end]| end > start) else {
        return Vec::new();
    };
    let count = ((end - start) / window_s).floor().min(MAX_WINDOWS) as usize;
    (0..=count).map(|i| start + i as f64 * window_s).collect()
}

fn add_pose(pose: &Stream<Pose>, edges: &[f64], windows: &mut Windows) {
    let Pose { x_m, y_m, yaw_rad } = &pose.values;
    let vx = rates(&pose.t_s, x_m, edges);
    let vy = rates(&pose.t_s, y_m, edges);
    let Some(yaw) = yaw_rad else {
        return;
    };
    let unwrapped = unwrap_angles(yaw);
    windows.pose_w = rates(&pose.t_s, &unwrapped, edges);
    let middles = edges
        .iter()
        .zip(edges.iter().skip(1))
        .map(|(start, end)| (start + end) / 2.0);
    let headings: Vec<f64> = middles
        .map(|t_s| interpolate(&pose.t_s, &unwrapped, t_s))
        .collect();
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

fn add_wheels(
    wheels: &Stream<Wheels>,
    counts_per_rev: Option<u32>,
    edges: &[f64],
    windows: &mut Windows,
) {
    windows.wheels_in_rad = true;
    (windows.wheel_right, windows.wheel_left) = match &wheels.values {
        Wheels::Ticks { right, left } => {
            windows.wheels_in_rad = counts_per_rev.is_some();
            let rad_per_count = counts_per_rev.map_or(1.0, |counts| TAU / f64::from(counts));
            let angles = |counts: &[Option<i64>]| -> Vec<f64> {
                let angle = |count: i64| count as f64 * rad_per_count;
                counts
                    .iter()
                    .map(|count| count.map_or(f64::NAN, angle))
                    .collect()
            };
            let rate = |counts| rates(&wheels.t_s, &angles(counts), edges);
            (rate(right), rate(left))
        }
        Wheels::Angle {
            right_rad,
            left_rad,
        } => (
            rates(&wheels.t_s, right_rad, edges),
            rates(&wheels.t_s, left_rad, edges),
        ),
        Wheels::Speed {
            right_rad_s,
            left_rad_s,
        } => (
            means(&wheels.t_s, right_rad_s, edges),
            means(&wheels.t_s, left_rad_s, edges),
        ),
    };
}

fn add_command(command: &Stream<Command>, edges: &[f64], windows: &mut Windows) {
    let mean = |cells: &[f64]| means(&command.t_s, cells, edges);
    match &command.values {
        Command::Twist { v_m_s, w_rad_s } => {
            (windows.command_v, windows.command_w) = (mean(v_m_s), mean(w_rad_s));
        }
        Command::WheelSpeed {
            right_rad_s,
            left_rad_s,
        } => {
            windows.command_right = mean(right_rad_s);
            windows.command_left = mean(left_rad_s);
        }
        Command::Torque {
            right_nm: right,
            left_nm: left,
        }
        | Command::Voltage {
            right_v: right,
            left_v: left,
        } => {
            windows.drive_right = mean(right);
            windows.drive_left = mean(left);
        }
    }
}
