//! What a recording says about one robot, in the form that the fit reads: commands, and
//! measurements with their standard deviations.

use std::f64::consts::TAU;

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{
    Command as Told, PosePoint, Recording, Robot as Recorded, Wheels as WheelStream,
};
use slipstream_sim::Command;

use crate::Unusable;

/// Standard deviation of a rounding to whole counts (counts).
const ROUNDING: f64 = 0.288_675_134_594_812_9;

/// Standard deviations where the recording declares none: an overhead camera's.
const POSE_M: f64 = 0.002;
const POSE_RAD: f64 = 0.009;

/// One robot's recording.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    pub(crate) robot: String,
    /// From when (s) each command holds.
    pub(crate) commands: Vec<(f64, Command)>,
    /// Stamp (s) and angles of the right and the left wheel (rad).
    pub(crate) wheels: Vec<(f64, [f64; 2])>,
    pub(crate) wheel_rad: f64,
    /// Stamp (s), x and y (m) and yaw (rad) of the tracked point.
    pub(crate) poses: Vec<(f64, [f64; 3])>,
    pub(crate) pose_deviation: [f64; 3],
    /// From c forward to the tracked point (m).
    pub(crate) tracked_ahead_m: f64,
}

impl Track {
    /// The track of `robot`.
    ///
    /// # Errors
    /// A robot without commands, or without anything that was measured.
    pub(crate) fn new(
        recording: &Recording,
        robot: &Recorded,
        model: &RobotModel,
    ) -> Result<Self, Unusable> {
        let place = format!("{}: {}", recording.name, robot.name);
        let commands = commands(robot).ok_or_else(|| {
            Unusable::new(
                &place,
                "has no command.csv",
                "record what the actuators were told",
            )
        })?;
        let counts = robot
            .encoder_counts_per_rev
            .or_else(|| model.encoder.as_ref().map(|e| e.counts_per_rev));
        let (wheels, wheel_rad) = wheels(robot, counts);
        let poses = poses(robot);
        if wheels.is_empty() && poses.is_empty() {
            let remedy = "record wheels.csv or pose.csv";
            return Err(Unusable::new(
                place,
                "has nothing that was measured",
                remedy,
            ));
        }
        let noise = &robot.noise;
        let pose_m = noise.pose_m.unwrap_or(POSE_M);
        let axle = robot.pose_point == Some(PosePoint::Axle);
        let back = if axle {
            model.robot.com_to_axle_m.unwrap_or(0.0)
        } else {
            0.0
        };
        Ok(Self {
            robot: robot.name.clone(),
            commands,
            wheels,
            wheel_rad: noise.wheel_rad.unwrap_or(wheel_rad),
            poses,
            pose_deviation: [pose_m, pose_m, noise.pose_rad.unwrap_or(POSE_RAD)],
            tracked_ahead_m: -back,
        })
    }

    /// From the first command to the last thing measured (s).
    pub(crate) fn span_s(&self) -> [f64; 2] {
        let from = self.commands.first().map_or(0.0, |(t_s, _)| *t_s);
        let wheels = self.wheels.last().map_or(from, |(t_s, _)| *t_s);
        let poses = self.poses.last().map_or(from, |(t_s, _)| *t_s);
        [from, wheels.max(poses)]
    }
}

fn commands(robot: &Recorded) -> Option<Vec<(f64, Command)>> {
    let stream = robot.command.as_ref()?;
    let pair = |a: &[f64], b: &[f64], make: fn(f64, f64) -> Command| {
        let values = a.iter().zip(b).map(|(&a, &b)| make(a, b));
        stream.t_s.iter().copied().zip(values).collect::<Vec<_>>()
    };
    let list = match &stream.values {
        Told::Torque { right_nm, left_nm } => pair(right_nm, left_nm, |right_nm, left_nm| {
            Command::Torque { right_nm, left_nm }
        }),
        Told::Voltage { right_v, left_v } => pair(right_v, left_v, |right_v, left_v| {
            Command::Voltage { right_v, left_v }
        }),
        Told::WheelSpeed {
            right_rad_s,
            left_rad_s,
        } => pair(right_rad_s, left_rad_s, |right_rad_s, left_rad_s| {
            Command::Speed {
                right_rad_s,
                left_rad_s,
            }
        }),
        Told::Twist { v_m_s, w_rad_s } => pair(v_m_s, w_rad_s, |v_m_s, w_rad_s| Command::Twist {
            v_m_s,
            w_rad_s,
        }),
    };
    (!list.is_empty()).then_some(list)
}

fn wheels(robot: &Recorded, counts: Option<u32>) -> (Vec<(f64, [f64; 2])>, f64) {
    let Some(stream) = &robot.wheels else {
        return (Vec::new(), 1.0);
    };
    let times = stream.t_s.iter().copied();
    match &stream.values {
        WheelStream::Ticks { right, left } => {
            let Some(counts) = counts else {
                return (Vec::new(), 1.0);
            };
            let tick = TAU / f64::from(counts);
            // the counter rounds down: the angle lies half a count higher on average
            let angle = |count: i64| (count as f64 + 0.5) * tick;
            let rows = times
                .zip(right.iter().zip(left))
                .filter_map(|(t_s, (right, left))| {
                    Some((t_s, [angle((*right)?), angle((*left)?)]))
                });
            (rows.collect(), ROUNDING * tick)
        }
        WheelStream::Angle {
            right_rad,
            left_rad,
        } => {
            let rows = times.zip(right_rad.iter().zip(left_rad).map(|(&r, &l)| [r, l]));
            (
                rows.filter(|(_, [r, l])| r.is_finite() && l.is_finite())
                    .collect(),
                1e-3,
            )
        }
        WheelStream::Speed { .. } => (Vec::new(), 1.0),
    }
}

fn poses(robot: &Recorded) -> Vec<(f64, [f64; 3])> {
    let Some(stream) = &robot.pose else {
        return Vec::new();
    };
    let yaw = stream.values.yaw_rad.as_deref();
    let rows = stream.t_s.iter().enumerate().map(|(i, &t_s)| {
        let yaw = yaw.map_or(f64::NAN, |yaw| yaw[i]);
        (t_s, [stream.values.x_m[i], stream.values.y_m[i], yaw])
    });
    rows.filter(|(_, [x, y, _])| x.is_finite() && y.is_finite())
        .collect()
}
