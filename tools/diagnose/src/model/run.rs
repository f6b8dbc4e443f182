//! One run: how its wheels turned, what they are compared with, and first guesses of its noise.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{PosePoint, Robot};
use slipstream_sim::Scalar;

use super::comparison::course;
use super::drive::{DRIVE, Response};
use crate::data::command::{self, CommandPath};
use crate::data::reference::{PoseRow, Span, Thinned, gyro, poses, seen_way_m};
use crate::data::wheel_path::{Turned, WheelPath, median_interval};
use crate::data::wheels;
use crate::estimate::blocks::Blocks;
use crate::filter::gyro as gyro_filter;
use crate::filter::wheels_to_pose;

/// Logarithms of noise sizes of a run: those of the pose's filter, then those of the gyro's.
pub(super) const RUN_NOISE: usize = wheels_to_pose::NOISE + gyro_filter::NOISE;

/// Whether a noise size of a run moves the robot, and is none of a sensor: the first six of the pose's filter, the
/// first three of the gyro's and its disturbance.
pub(super) fn is_process(number: usize) -> bool {
    let of_gyro = number.checked_sub(wheels_to_pose::NOISE);
    of_gyro.map_or(number < 6, |own| own < 3 || own == 5)
}

/// Least distance that a run's wheels have to roll, in half tracks.
const LEAST_WAY: f64 = 4.0;
/// Where a reference went that far, wheels may have counted too little by this factor: turns for degrees.
const MOST_FACTOR: f64 = 400.0;
/// Speeds and turns that take less than this share of the time lie beyond the knots of a law.
const RARE_SHARE: f64 = 0.005;
/// Interval at which the wheels of a simulated drive count as known (s).
const COMMANDED_STEP_S: f64 = 0.02;

/// How the wheels turned.
#[derive(Debug, Clone)]
pub(crate) enum Source {
    Measured(WheelPath),
    /// No wheels were recorded: they turn as the drive follows its commands.
    Commanded(CommandPath),
}

/// One run.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    /// Which of the robots it is of.
    pub(crate) robot: usize,
    /// What its times count from (s).
    pub(crate) origin_s: f64,
    pub(crate) wheels: Source,
    pub(crate) wheel_interval_s: f64,
    pub(crate) pose: Option<Thinned<PoseRow>>,
    pub(crate) gyro: Option<Thinned<(f64, f64)>>,
    pub(crate) declared_m: f64,
    pub(crate) first_heading_rad: f64,
    pub(crate) blocks: Blocks,
}

/// The first speed beyond those that take `rare_s` seconds together; 0 without any.
fn first_common<'a>(mut rows: impl Iterator<Item = &'a (f64, f64)>, rare_s: f64) -> f64 {
    let mut passed_s = 0.0;
    let found = rows.find(|(_, held_s)| {
        passed_s += held_s;
        passed_s > rare_s
    });
    found.map_or(0.0, |(speed, _)| *speed)
}

impl Source {
    fn new(robot: &Robot, model: &RobotModel, origin_s: f64) -> Option<Self> {
        if let Some(path) = wheels::path(robot, model, origin_s) {
            return Some(Self::Measured(path));
        }
        command::commands(robot, model, origin_s).map(Self::Commanded)
    }

    /// How far both wheels turned, all told (rad).
    pub(super) fn turned_rad(&self) -> f64 {
        match self {
            Self::Measured(path) => {
                let pairs = path.angles_rad.windows(2);
                let turned = pairs.map(|p| (p[1][0] - p[0][0]).abs() + (p[1][1] - p[0][1]).abs());
                turned.sum()
            }
            Self::Commanded(path) => {
                let held_s = path.times_s.windows(2).map(|t| t[1] - t[0]);
                let held_s = held_s.chain([1.0]).zip(&path.speeds_rad_s);
                held_s.map(|(h, u)| h * (u[0].abs() + u[1].abs())).sum()
            }
        }
    }

    /// How much farther one wheel turned than the other at most (rad).
    pub(super) fn most_turned_rad(&self) -> f64 {
        match self {
            Self::Measured(path) => {
                let first = path.angles_rad[0];
                let turned = path.angles_rad.iter().map(|own| own[0] - own[1]);
                turned.fold(0.0, |most, own| {
                    f64::max(most, (own - first[0] + first[1]).abs())
                })
            }
            Self::Commanded(_) => f64::INFINITY,
        }
    }

    /// Ranges of half the difference and half the sum of the wheels' speeds, without what is rare
    /// (rad/s).
    pub(super) fn ranges_rad_s(&self) -> [[f64; 2]; 2] {
        let speeds: Vec<([f64; 2], f64)> = match self {
            Self::Measured(path) => {
                let pairs = path.times_s.windows(2).zip(path.angles_rad.windows(2));
                let speeds = pairs.map(|(t, a)| {
                    let h = t[1] - t[0];
                    ([0, 1].map(|i| (a[1][i] - a[0][i]) / h), h)
                });
                speeds.collect()
            }
            Self::Commanded(path) => {
                let held_s = path.times_s.windows(2).map(|t| t[1] - t[0]).chain([0.0]);
                path.speeds_rad_s.iter().copied().zip(held_s).collect()
            }
        };
        let range = |of: fn(&[f64; 2]) -> f64| {
            let mut all: Vec<(f64, f64)> = speeds.iter().map(|(u, h)| (of(u), *h)).collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            let total: f64 = all.iter().map(|(_, h)| h).sum();
            let rare_s = RARE_SHARE * total;
            [
                first_common(all.iter(), rare_s),
                first_common(all.iter().rev(), rare_s),
            ]
        };
        [
            range(|u| (u[0] - u[1]) / 2.0),
            range(|u| f64::midpoint(u[0], u[1])),
        ]
    }

    fn interval_s(&self) -> f64 {
        match self {
            Self::Measured(path) => path.interval_s(),
            Self::Commanded(_) => COMMANDED_STEP_S,
        }
    }

    /// When something is known of them (s).
    fn span_s(&self) -> [f64; 2] {
        match self {
            Self::Measured(path) => [path.times_s[0], path.times_s[path.times_s.len() - 1]],
            // the last command holds on
            Self::Commanded(path) => [path.times_s[0], f64::INFINITY],
        }
    }

    /// The commands as which they turn, where they were not recorded.
    pub(crate) fn commands(&self) -> Option<&CommandPath> {
        match self {
            Self::Measured(_) => None,
            Self::Commanded(path) => Some(path),
        }
    }

    pub(crate) fn is_commanded(&self) -> bool {
        matches!(self, Self::Commanded(_))
    }

    /// Calls `with` with the wheels of a drive with these parameters.
    pub(crate) fn turned<S: Scalar, T>(
        &self,
        drive: &[S],
        with: impl FnOnce(&dyn Turned<S>) -> T,
    ) -> T {
        match self {
            Self::Measured(path) => with(path),
            Self::Commanded(path) => with(&Response::new(path, drive)),
        }
    }
}

impl Run {
    /// How the wheels turned, piece by piece (rad).
    pub(super) fn course(&self) -> Vec<f64> {
        let times_s = match &self.wheels {
            Source::Measured(path) => &path.times_s,
            Source::Commanded(path) => &path.times_s,
        };
        let (Some(first), Some(last)) = (times_s.first(), times_s.last()) else {
            return Vec::new();
        };
        let span_s = [*first, *last];
        self.wheels
            .turned(&[0.0; DRIVE], |wheels| course(wheels, span_s))
    }

    pub(super) fn new(
        robot: &Robot,
        model: &RobotModel,
        excluded_s: &[[f64; 2]],
        first_block: usize,
    ) -> Option<Self> {
        let origin_s = crate::data::origin_of(robot);
        let wheels = Source::new(robot, model, origin_s)?;
        let wheel_interval_s = wheels.interval_s();
        let span = Span {
            origin_s,
            excluded_s,
            wheels_s: wheels.span_s(),
        };
        let pose = poses(robot, span);
        let way_m = wheels.turned_rad() * model.robot.wheel_radius_m;
        let seen_m = pose.as_ref().map_or(0.0, |pose| seen_way_m(&pose.all));
        let least_m = LEAST_WAY * model.robot.half_track_m;
        if way_m < least_m && (seen_m < least_m || way_m * MOST_FACTOR < least_m) {
            return None;
        }
        let gyro = gyro(robot, span, wheel_interval_s);
        let ends = |rows: Option<(f64, f64)>| rows.into_iter().flat_map(|(a, b)| [a, b]);
        let pose_ends = pose
            .as_ref()
            .and_then(|p| Some((p.all.first()?.0, p.all.last()?.0)));
        let gyro_ends = gyro
            .as_ref()
            .and_then(|p| Some((p.all.first()?.0, p.all.last()?.0)));
        let mut all: Vec<f64> = ends(pose_ends).chain(ends(gyro_ends)).collect();
        if all.is_empty() && !wheels.is_commanded() {
            all.extend(wheels.span_s());
        }
        let from_s = all.iter().copied().fold(f64::INFINITY, f64::min);
        let to_s = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if all.is_empty() {
            return None;
        }
        let ahead_m = model.robot.com_to_axle_m.unwrap_or(0.0);
        let axle = robot.pose_point == Some(PosePoint::Axle);
        Some(Self {
            robot: 0,
            origin_s,
            wheel_interval_s,
            wheels,
            pose,
            gyro,
            declared_m: if axle { 0.0 } else { ahead_m },
            first_heading_rad: 0.0,
            blocks: Blocks::new([from_s, to_s], first_block),
        })
    }

    pub(crate) fn has_heading(&self) -> bool {
        self.pose.as_ref().is_some_and(|pose| {
            let seen = pose.all.iter().filter(|(_, z)| z[2].is_finite()).count();
            2 * seen > pose.all.len()
        })
    }

    /// Median time between rows of the gyro (s).
    pub(crate) fn gyro_interval_s(&self) -> f64 {
        self.gyro.as_ref().map_or(0.0, |gyro| {
            let times: Vec<f64> = gyro.all.iter().map(|row| row.0).collect();
            median_interval(&times)
        })
    }

    /// Median time between poses (s).
    pub(crate) fn pose_interval_s(&self) -> f64 {
        let times = |pose: &Thinned<PoseRow>| pose.all.iter().map(|row| row.0).collect::<Vec<_>>();
        self.pose
            .as_ref()
            .map_or(0.0, |pose| median_interval(&times(pose)))
    }

    /// Median time between rows of a thinned series of poses (s).
    pub(crate) fn pose_series_s(&self) -> Option<f64> {
        let rows = self.pose.as_ref()?.series.first()?;
        let times: Vec<f64> = rows.iter().map(|row| row.0).collect();
        Some(median_interval(&times)).filter(|interval_s| *interval_s > 0.0)
    }

    /// Logs of noise sizes to start from; those of the pose's sensor from second differences.
    pub(super) fn noise_guesses(&self, track_m: f64) -> [f64; RUN_NOISE] {
        let [place, yaw] = self
            .pose
            .as_ref()
            .map_or([1e-2; 2], |pose| sensor_noise(&pose.all));
        let root = track_m.sqrt();
        [
            0.1 * root,
            0.05 * root,
            0.05 / root,
            0.05,
            0.3 * place,
            0.3 * yaw,
            place,
            yaw,
            0.01,
            0.02 / root,
            0.03,
            0.003,
            0.001,
            0.005,
            0.03,
            0.5,
        ]
        .map(f64::ln)
    }
}

/// Order of the white noise of poses: place (m), yaw (rad), from medians of second differences.
pub(crate) fn sensor_noise(rows: &[PoseRow]) -> [f64; 2] {
    let median = |i: usize| {
        let seconds = rows.windows(3).map(|w| {
            let d = [w[1].1[i] - w[0].1[i], w[2].1[i] - w[1].1[i]];
            let d = if i == 2 {
                d.map(crate::filter::wrapped::<f64>)
            } else {
                d
            };
            (d[1] - d[0]).abs()
        });
        let mut all: Vec<f64> = seconds.filter(|d| d.is_finite() && *d > 0.0).collect();
        all.sort_by(f64::total_cmp);
        // deviation of a second difference of white noise is sqrt 6; median of |normal| is 0.67
        all.get(all.len() / 2).map(|m| m / 0.67 / 6.0_f64.sqrt())
    };
    let place = [median(0), median(1)].into_iter().flatten().sum::<f64>() / 2.0;
    [place.max(1e-5), median(2).unwrap_or(0.01).max(1e-5)]
}
