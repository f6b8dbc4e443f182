//! Which changes are put into a recording: what its streams could show, from small to large.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{Command, Robot};

use super::change::Change;

/// Sizes of each change, as multiples of the middle one.
const SIZES: [f64; 3] = [0.4, 1.0, 2.5];
/// Middle sizes: latency (s), rate of a clock, place and yaw of the reference (half tracks, rad), radii,
/// counts and gains (shares), delay of commands (s), dead zone (share of the largest command).
const LATE_S: f64 = 0.06;
const RATE: f64 = 1.5e-3;
const OFFSET: f64 = 0.3;
const TURNED_RAD: f64 = 0.05;
const SHARE: f64 = 0.04;
const DELAY_S: f64 = 0.05;
const ZONE: f64 = 0.06;

/// The changes for a robot, in three sizes each, with both signs.
pub(super) fn changes(robot: &Robot, model: &RobotModel) -> Vec<Change> {
    let kinds = kinds(robot, model);
    let each = kinds.iter().enumerate().flat_map(|(kind, of)| {
        SIZES.iter().enumerate().map(move |(size, multiple)| {
            let sign = if (kind + size) % 2 == 0 { 1.0 } else { -1.0 };
            of(sign * multiple)
        })
    });
    each.collect()
}

type ChangeKind = Box<dyn Fn(f64) -> Change>;

fn kinds(robot: &Robot, model: &RobotModel) -> Vec<ChangeKind> {
    let mut kinds: Vec<ChangeKind> = Vec::new();
    let wheels = robot.wheels.is_some();
    let speeds = robot.command.as_ref().is_some_and(|own| {
        matches!(
            own.values,
            Command::Twist { .. } | Command::WheelSpeed { .. }
        )
    });
    let told = robot.command.is_some();
    let b = model.robot.half_track_m;
    if let Some(pose) = &robot.pose {
        kinds.push(Box::new(|x| Change::PoseLate(LATE_S * x)));
        kinds.push(Box::new(|x| Change::PoseClock(RATE * x)));
        if pose.values.yaw_rad.is_some() {
            kinds.push(Box::new(move |x| Change::Offset([OFFSET * b * x, 0.0])));
            kinds.push(Box::new(move |x| Change::Offset([0.0, OFFSET * b * x])));
            kinds.push(Box::new(|x| Change::Turned(TURNED_RAD * x)));
        }
    }
    if robot
        .imu
        .as_ref()
        .is_some_and(|imu| imu.values.gz_rad_s.is_some())
    {
        kinds.push(Box::new(|x| Change::GyroLate(LATE_S * x)));
    }
    let share = |x: f64| (SHARE * x).exp();
    if wheels && !told && robot.pose.is_some() {
        kinds.push(Box::new(move |x| Change::Radius([share(x); 2])));
        kinds.push(Box::new(move |x| Change::Radius([share(x), 1.0])));
    }
    if wheels && told {
        kinds.push(Box::new(move |x| Change::Counts([share(x); 2])));
        kinds.push(Box::new(|x| Change::WheelsLate(LATE_S * x)));
    }
    if told {
        // a delay and a dead zone cannot be negative
        kinds.push(Box::new(|x| Change::CommandLate(DELAY_S * x.abs())));
        kinds.push(Box::new(move |x| Change::Gain(share(x))));
    }
    if speeds {
        let top = largest(robot, model);
        kinds.push(Box::new(move |x| Change::DeadZone(ZONE * top * x.abs())));
    }
    kinds
}

/// The largest commanded speed of a wheel (rad/s).
fn largest(robot: &Robot, model: &RobotModel) -> f64 {
    let [r, b] = [model.robot.wheel_radius_m, model.robot.half_track_m];
    let most = |a: &[f64], c: &[f64], of: &dyn Fn(f64, f64) -> f64| {
        let all = a.iter().zip(c).map(|(a, c)| of(*a, *c));
        all.fold(0.0, f64::max)
    };
    match robot.command.as_ref().map(|own| &own.values) {
        Some(Command::Twist { v_m_s, w_rad_s }) => {
            most(v_m_s, w_rad_s, &|v, w| (v.abs() + b * w.abs()) / r)
        }
        Some(Command::WheelSpeed {
            right_rad_s,
            left_rad_s,
        }) => most(right_rad_s, left_rad_s, &|right, left| {
            right.abs().max(left.abs())
        }),
        _ => 0.0,
    }
}
