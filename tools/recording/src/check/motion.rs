//! The same motion as each source tells it, in windows of half a second or more.
//!
//! Wheels and poses are differences over the window, so their noise averages out; rates are means
//! over the rows in it. A source that says nothing in a window is NaN there.

use std::f64::consts::TAU;

use slipstream_bus::RobotModel;

use super::resample::{at, means, rates};
use crate::recording::{Command, Pose, Robot, Stream, Wheels, unwrap};

/// Shortest window (s).
const SHORTEST_S: f64 = 0.5;
/// Most windows that a recording is cut into.
const MOST: f64 = 20_000.0;

/// What every source says, window by window; each list as long as there are windows.
#[derive(Debug, Default)]
pub(super) struct Windows {
    /// Forward speed by the pose (m/s).
    pub(super) pose_v: Vec<f64>,
    /// Yaw rate by the pose (rad/s).
    pub(super) pose_w: Vec<f64>,
    /// Speed of the right wheel: rad/s, or counts/s where a turn is unknown.
    pub(super) wheel_right: Vec<f64>,
    /// Speed of the left wheel, likewise.
    pub(super) wheel_left: Vec<f64>,
    /// Yaw rate by the gyro (rad/s).
    pub(super) gyro_w: Vec<f64>,
    /// Forward speed by the odometry (m/s).
    pub(super) odometry_v: Vec<f64>,
    /// Commanded forward speed (m/s).
    pub(super) command_v: Vec<f64>,
    /// Commanded yaw rate (rad/s).
    pub(super) command_w: Vec<f64>,
    /// Commanded speed of the right wheel (rad/s).
    pub(super) command_right: Vec<f64>,
    /// Commanded speed of the left wheel (rad/s).
    pub(super) command_left: Vec<f64>,
    /// Torque (N m) or voltage (V) at the right wheel, as told.
    pub(super) drive_right: Vec<f64>,
    /// Torque or voltage at the left wheel, likewise.
    pub(super) drive_left: Vec<f64>,
    /// Whether the wheels are in radians.
    pub(super) wheels_in_rad: bool,
    /// r (m) and b (m), where a model gives them.
    pub(super) size_m: Option<[f64; 2]>,
    /// By the pose: cosine of the angle from the heading to the direction of motion, the yaw taken
    /// as radians and as degrees. NaN where it hardly moves.
    pub(super) heading_cos: [Vec<f64>; 2],
}

/// Cuts a robot's recording into windows of half a second or more.
pub(super) fn windows(robot: &Robot, model: Option<&RobotModel>) -> Windows {
    let span_s = span(robot).map_or(0.0, |[start, end]| end - start);
    cut(robot, model, SHORTEST_S.max(span_s / MOST))
}

/// Cuts a robot's recording into windows of this length (s).
pub(super) fn cut(robot: &Robot, model: Option<&RobotModel>, window_s: f64) -> Windows {
    let edges = edges(robot, window_s);
    let mut windows = Windows {
        size_m: model.map(|model| [model.robot.wheel_radius_m, model.robot.half_track_m]),
        ..Windows::default()
    };
    if let Some(pose) = &robot.pose {
        of_pose(pose, &edges, &mut windows);
    }
    if let Some(wheels) = &robot.wheels {
        let model = model.and_then(|model| model.encoder.as_ref());
        let counts = robot
            .encoder_counts_per_rev
            .or(model.map(|e| e.counts_per_rev));
        of_wheels(wheels, counts, &edges, &mut windows);
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
        let mean = |cells: &Vec<f64>| means(&command.t_s, cells, &edges);
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
    windows
}

/// First and last time (s) of the streams that tell a motion.
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

/// The windows' borders (s), over the whole recording, no more than [`MOST`] windows.
fn edges(robot: &Robot, window_s: f64) -> Vec<f64> {
    let Some([start, end]) = span(robot).filter(|[start, end]| end > start) else {
        return Vec::new();
    };
    let count = ((end - start) / window_s).floor().min(MOST) as usize;
    (0..=count).map(|i| start + i as f64 * window_s).collect()
}

fn of_pose(pose: &Stream<Pose>, edges: &[f64], windows: &mut Windows) {
    let Pose { x_m, y_m, yaw_rad } = &pose.values;
    let vx = rates(&pose.t_s, x_m, edges);
    let vy = rates(&pose.t_s, y_m, edges);
    let Some(yaw) = yaw_rad else {
        return;
    };
    let unwrapped = unwrap(yaw);
    windows.pose_w = rates(&pose.t_s, &unwrapped, edges);
    let middles = edges
        .iter()
        .zip(edges.iter().skip(1))
        .map(|(a, b)| (a + b) / 2.0);
    let headings: Vec<f64> = middles.map(|t_s| at(&pose.t_s, &unwrapped, t_s)).collect();
    let along = |heading: f64, (x, y): (&f64, &f64)| x * heading.cos() + y * heading.sin();
    let velocities = || vx.iter().zip(&vy);
    windows.pose_v = headings
        .iter()
        .zip(velocities())
        .map(|(heading, v)| along(*heading, v))
        .collect();
    // A window's direction of motion counts where it moves by more than a fifth of its fastest.
    let fastest = velocities().map(|(x, y)| x.hypot(*y)).fold(0.0, f64::max);
    for (cosines, unit) in windows.heading_cos.iter_mut().zip([1.0, TAU / 360.0]) {
        let pairs = headings.iter().zip(velocities());
        *cosines = pairs
            .map(|(heading, (x, y))| {
                let speed = x.hypot(*y);
                let moves = speed > 0.2 * fastest;
                if moves {
                    along(heading * unit, (x, y)) / speed
                } else {
                    f64::NAN
                }
            })
            .collect();
    }
}

fn of_wheels(
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
            let angle = |counts: &[Option<i64>]| -> Vec<f64> {
                let angle = |count: i64| count as f64 * rad_per_count;
                counts
                    .iter()
                    .map(|count| count.map_or(f64::NAN, angle))
                    .collect()
            };
            let rate = |counts| rates(&wheels.t_s, &angle(counts), edges);
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
