//! What a recording says about one robot, in the form that the fit reads: what drove it, and
//! measurements with their standard deviations.

use std::f64::consts::TAU;

use slipstream_bus::{Body, RobotModel};
use slipstream_recording::recording::{ImuKind, PosePoint, Recording, Robot as Recorded};
use slipstream_sim::{Command, CommandKind, Stream};

use super::streams::{self, WheelKind};
use crate::data::noise;
use slipstream_bus::InputError;

/// Channels of measurement: right and left wheel, x, y and yaw of the pose, v and w of the
/// odometry, ax, ay and gz of the inertial sensor.
pub(crate) const CHANNELS: usize = 10;

/// Names of the channels in `held_out`.
pub(crate) const CHANNEL_NAMES: [&str; CHANNELS] = [
    "wheel_right",
    "wheel_left",
    "pose_x",
    "pose_y",
    "pose_yaw",
    "odometry_v",
    "odometry_w",
    "imu_ax",
    "imu_ay",
    "imu_gz",
];

/// What a series of measurements is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sensor {
    WheelAngle,
    WheelSpeed,
    Pose,
    Odometry,
    Imu,
}

impl Sensor {
    /// The first of its channels.
    pub(crate) fn channel(self) -> usize {
        match self {
            Self::WheelAngle | Self::WheelSpeed => 0,
            Self::Pose => 2,
            Self::Odometry => 5,
            Self::Imu => 7,
        }
    }

    /// How many numbers a row has.
    pub(crate) fn width(self) -> usize {
        match self {
            Self::WheelAngle | Self::WheelSpeed | Self::Odometry => 2,
            Self::Pose | Self::Imu => 3,
        }
    }

    /// Whose clock stamps it. The odometry is made of the wheels.
    pub(crate) fn clock(self) -> Stream {
        match self {
            Self::WheelAngle | Self::WheelSpeed | Self::Odometry => Stream::Wheels,
            Self::Pose => Stream::Pose,
            Self::Imu => Stream::Imu,
        }
    }
}

/// Rows of one sensor. What it did not see is NaN.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    pub(crate) sensor: Sensor,
    /// Stamp (s) and values.
    pub(crate) rows: Vec<(f64, [f64; 3])>,
    pub(crate) deviation: [f64; 3],
    /// The deviation is what the rows themselves show: neither declared nor that of a rounding.
    pub(crate) is_guessed: bool,
}

/// What the simulation is driven by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Driver {
    /// What the actuators were told.
    Command,
    /// How the wheels turned, where nothing is known of commands.
    Wheels,
}

/// One robot's recording.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    pub(crate) recording: String,
    pub(crate) robot: String,
    pub(crate) driver: Driver,
    /// From when (s) each command holds.
    pub(crate) commands: Vec<(f64, Command)>,
    pub(crate) series: Vec<Series>,
    /// Intervals (s) excluded from the analysis and from the simulation.
    pub(crate) left_out_s: Vec<[f64; 2]>,
    /// From c forward to the tracked point (m).
    pub(crate) tracked_ahead_m: f64,
    /// The accelerometer leaves weight out.
    pub(crate) imu_without_weight: bool,
}

/// Wheel radius, half track and the way from the axle to the centre of mass (m).
pub(crate) fn geometry(body: &Body) -> [f64; 3] {
    let ahead_m = body.com_to_axle_m.unwrap_or(0.0);
    [body.wheel_radius_m, body.half_track_m, ahead_m]
}

/// How much later than the first command a first measurement comes late (s).
const LATE_S: f64 = 0.1;

impl Track {
    /// The track of `robot`, driven by its commands, or by its wheels where there are none.
    ///
    /// # Errors
    /// A robot without commands and wheels, or without anything that was measured.
    pub(crate) fn new(
        recording: &Recording,
        robot: &Recorded,
        model: &RobotModel,
    ) -> Result<Self, InputError> {
        let place = format!("{}: {}", recording.name, robot.name);
        let wheels = wheels(robot, model);
        let told = Some(streams::commands(robot)).filter(|told| !told.is_empty());
        let driver = if told.is_some() {
            Driver::Command
        } else {
            Driver::Wheels
        };
        let driven = told.or_else(|| wheels.as_ref().and_then(driven_by));
        let commands = driven.ok_or_else(|| {
            let remedy = "record command.csv, or wheels.csv with counts per turn";
            InputError::new(&place, "has neither commands nor wheels", remedy)
        })?;
        let mut series: Vec<Series> = Vec::new();
        series.extend(wheels.filter(|_| driver == Driver::Command));
        let others = [poses(robot), odometry(robot), imu(robot)];
        series.extend(others.into_iter().flatten());
        if !matches!(
            commands.first(),
            Some((_, Command::Torque { .. } | Command::Voltage { .. }))
        ) {
            // speeds that jump with their command have no acceleration to compare
            for series in series.iter_mut().filter(|s| s.sensor == Sensor::Imu) {
                series.rows.iter_mut().for_each(|(_, [along, across, _])| {
                    [*along, *across] = [f64::NAN; 2];
                });
            }
        }
        series.retain(|series| !series.rows.is_empty());
        if series.is_empty() {
            let remedy = "record pose.csv, wheels.csv beside a command, or imu.csv";
            return Err(InputError::new(
                place,
                "has nothing to compare with",
                remedy,
            ));
        }
        let axle = robot.pose_point == Some(PosePoint::Axle);
        let back = model.robot.com_to_axle_m.filter(|_| axle).unwrap_or(0.0);
        Ok(Self {
            recording: recording.name.clone(),
            robot: robot.name.clone(),
            driver,
            commands,
            series,
            left_out_s: Vec::new(),
            tracked_ahead_m: -back,
            imu_without_weight: robot.imu_kind == Some(ImuKind::Acceleration),
        })
    }

    /// Where wheels that do not slip took the centre of mass by each of these times (s, rising), from the
    /// origin and facing along x when the recording began: x and y (m) and heading (rad). `None` without
    /// wheel angles. The lengths are those of [`geometry`].
    pub(crate) fn reckoned(
        &self,
        times_s: &[f64],
        [r, b, ahead]: [f64; 3],
    ) -> Option<Vec<[f64; 3]>> {
        let rows = &self.of(Sensor::WheelAngle)?.rows;
        let further = |[x, y, heading]: [f64; 3], from: [f64; 3], to: [f64; 3], share: f64| {
            let [right, left] = [0, 1].map(|i| share * (to[i] - from[i]));
            let (way, turn) = (r * (right + left) / 2.0, r * (right - left) / (2.0 * b));
            let (sin, cos) = (heading + turn / 2.0).sin_cos();
            [x + way * cos, y + way * sin, heading + turn]
        };
        let (mut axle, mut at) = ([0.0; 3], 0);
        let poses = times_s.iter().map(|t_s| {
            while let Some([from, to]) = rows.get(at..at + 2)
                && to.0 <= *t_s
            {
                axle = further(axle, from.1, to.1, 1.0);
                at += 1;
            }
            let [x, y, heading] = match rows.get(at..at + 2) {
                Some([from, to]) if *t_s > from.0 => {
                    further(axle, from.1, to.1, (t_s - from.0) / (to.0 - from.0))
                }
                _ => axle,
            };
            let (sin, cos) = heading.sin_cos();
            [x + ahead * (cos - 1.0), y + ahead * sin, heading]
        });
        Some(poses.collect())
    }

    /// Believes nothing measured in these times (s).
    pub(crate) fn leave_out(&mut self, times_s: &[[f64; 2]]) {
        self.left_out_s.extend(times_s);
        for series in &mut self.series {
            series
                .rows
                .retain(|(t_s, _)| !times_s.iter().any(|[from, to]| (from..=to).contains(&t_s)));
        }
    }

    /// Keeps every so manyth row of series that have more than `most`.
    pub(crate) fn thin(&mut self, most: usize) {
        for series in &mut self.series {
            let stride = series.rows.len().div_ceil(most).max(1);
            let mut at = 0;
            series.rows.retain(|_| {
                at += 1;
                (at - 1) % stride == 0
            });
        }
    }

    /// The series of `sensor`.
    pub(crate) fn of(&self, sensor: Sensor) -> Option<&Series> {
        self.series.iter().find(|series| series.sensor == sensor)
    }

    /// Which of the series is that of `sensor`.
    pub(crate) fn place(&self, sensor: Sensor) -> Option<usize> {
        self.series
            .iter()
            .position(|series| series.sensor == sensor)
    }

    /// The quantity that commands set.
    pub(crate) fn kind(&self) -> CommandKind {
        match self.commands.first() {
            Some((_, Command::Voltage { .. })) => CommandKind::Voltage,
            Some((_, Command::Speed { .. } | Command::Twist { .. })) => CommandKind::Speed,
            _ => CommandKind::Torque,
        }
    }

    /// From the first command to the last thing measured (s).
    pub(crate) fn span_s(&self) -> [f64; 2] {
        let from = self.commands.first().map_or(0.0, |(t_s, _)| *t_s);
        let ends = self.series.iter().filter_map(|s| s.rows.last());
        let to = ends.map(|(t_s, _)| *t_s).fold(from, f64::max);
        let last = self.commands.last().map_or(from, |(t_s, _)| *t_s);
        let held = if self.driver == Driver::Wheels {
            last
        } else {
            to
        };
        [from, to.min(held)]
    }

    /// The stretches (s) that are not left out, from the first command on, or from the first
    /// measurement if that comes late.
    pub(crate) fn stretches_s(&self) -> Vec<[f64; 2]> {
        let [from, to] = self.span_s();
        let firsts = self.series.iter().filter_map(|s| s.rows.first());
        let first = firsts.map(|(t_s, _)| *t_s).fold(to, f64::min);
        // a robot that stood when its commands began is known better than one seen a little later
        let first = if first > from + LATE_S { first } else { from };
        let mut left_out = self.left_out_s.clone();
        left_out.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (mut stretches, mut begin) = (Vec::new(), first);
        for [out, back] in left_out {
            if out > begin {
                stretches.push([begin, out.min(to)]);
            }
            begin = begin.max(back);
        }
        stretches.push([begin, to]);
        stretches
    }
}

/// The wheels. The deviation is the declared one, that of the rounding, or what the rows themselves show.
fn wheels(robot: &Recorded, model: &RobotModel) -> Option<Series> {
    let read = streams::wheels(robot, model)?;
    let rows: Vec<(f64, [f64; 3])> = read
        .rows
        .into_iter()
        .map(|(t_s, [right, left])| (t_s, [right, left, f64::NAN]))
        .collect();
    let sensor = match read.kind {
        WheelKind::Angle => Sensor::WheelAngle,
        WheelKind::Speed => Sensor::WheelSpeed,
    };
    let known = robot
        .noise
        .wheel_rad
        .filter(|_| sensor == Sensor::WheelAngle);
    let one = known.or(read.rounding_rad);
    let deviation = [0, 1].map(|i| one.unwrap_or_else(|| own_deviation(&rows, i, 1e-4)));
    Some(Series {
        sensor,
        rows,
        deviation: [deviation[0], deviation[1], 1.0],
        is_guessed: one.is_none(),
    })
}

fn own_deviation(rows: &[(f64, [f64; 3])], part: usize, least: f64) -> f64 {
    let rows: Vec<(f64, f64)> = rows
        .iter()
        .map(|(t_s, values)| (*t_s, values[part]))
        .filter(|(_, value)| value.is_finite())
        .collect();
    noise::deviation(&rows).unwrap_or(least).max(least)
}

/// Wheel speeds that lead from each row of the wheels to the next.
fn driven_by(wheels: &Series) -> Option<Vec<(f64, Command)>> {
    let rows = &wheels.rows;
    let speed = |[right_rad_s, left_rad_s]: [f64; 2]| Command::Speed {
        right_rad_s,
        left_rad_s,
    };
    let pairs = rows.windows(2).filter(|pair| pair[1].0 > pair[0].0);
    let list: Vec<(f64, Command)> = pairs
        .map(|pair| {
            let [(from_s, a), (to_s, b)] = [pair[0], pair[1]];
            let mean = |i: usize| match wheels.sensor {
                Sensor::WheelAngle => (b[i] - a[i]) / (to_s - from_s),
                _ => (a[i] + b[i]) / 2.0,
            };
            (from_s, speed([mean(0), mean(1)]))
        })
        .collect();
    (!list.is_empty()).then_some(list)
}

/// The poses, whose yaw goes on over a whole turn.
fn poses(robot: &Recorded) -> Option<Series> {
    let mut rows = streams::poses(robot)?;
    let (mut turns, mut last) = (0.0, f64::NAN);
    for (_, [.., yaw]) in rows.iter_mut().filter(|(_, row)| row[2].is_finite()) {
        if last.is_finite() {
            turns += ((last - *yaw) / TAU).round();
        }
        last = *yaw;
        *yaw += turns * TAU;
    }
    let noise = &robot.noise;
    let own = |i: usize, least: f64| own_deviation(&rows, i, least);
    let pose_m = noise
        .pose_m
        .unwrap_or_else(|| own(0, 1e-4).max(own(1, 1e-4)));
    let pose_rad = noise.pose_rad.unwrap_or_else(|| own(2, 1e-4));
    Some(Series {
        sensor: Sensor::Pose,
        rows,
        deviation: [pose_m, pose_m, pose_rad],
        is_guessed: noise.pose_m.or(noise.pose_rad).is_none(),
    })
}

fn odometry(robot: &Recorded) -> Option<Series> {
    let read = streams::odometry(robot)?.into_iter();
    let rows: Vec<_> = read.map(|(t_s, [v, w])| (t_s, [v, w, f64::NAN])).collect();
    let noise = &robot.noise;
    let v = noise
        .odometry_m_s
        .unwrap_or_else(|| own_deviation(&rows, 0, 1e-4));
    let w = noise
        .odometry_rad_s
        .unwrap_or_else(|| own_deviation(&rows, 1, 1e-4));
    Some(Series {
        sensor: Sensor::Odometry,
        rows,
        deviation: [v, w, 1.0],
        is_guessed: noise.odometry_m_s.or(noise.odometry_rad_s).is_none(),
    })
}

fn imu(robot: &Recorded) -> Option<Series> {
    let rows = streams::inertial(robot)?;
    let noise = &robot.noise;
    let along = |i: usize| {
        noise
            .imu_m_s2
            .unwrap_or_else(|| own_deviation(&rows, i, 1e-3))
    };
    let turn = noise
        .imu_rad_s
        .unwrap_or_else(|| own_deviation(&rows, 2, 1e-4));
    Some(Series {
        sensor: Sensor::Imu,
        deviation: [along(0), along(1), turn],
        is_guessed: noise.imu_m_s2.or(noise.imu_rad_s).is_none(),
        rows,
    })
}

#[cfg(test)]
mod tests {
    use slipstream_recording::recording::Pose;

    use super::*;
    use crate::predict::fixture;

    /// Between rows 20 ms apart the plant drives arcs that the sums take for chords.
    #[test]
    fn wheels_that_do_not_slip_lead_where_the_robot_is() {
        let model = RobotModel::default();
        let track = fixture::driven(&model, 6.0, fixture::gentle);
        let poses = track.of(Sensor::Pose).unwrap().rows.clone();
        let [.., last] = poses[..] else { panic!() };
        assert!(last.1[0].abs() > 0.5 && last.1[2].abs() > 0.1, "{last:?}");
        let times_s: Vec<f64> = poses.iter().map(|(t_s, _)| *t_s).collect();
        let reckoned = track.reckoned(&times_s, geometry(&model.robot)).unwrap();
        for (reckoned, (_, pose)) in reckoned.into_iter().zip(poses) {
            for (reckoned, seen) in reckoned.iter().zip(pose) {
                assert!((reckoned - seen).abs() < 1e-4, "{reckoned} for {seen}");
            }
        }
    }

    #[test]
    fn across_a_pause_the_wheels_turned_at_their_mean_speed() {
        let rows = [(0.0, 0.0), (0.1, 0.2), (2.1, 4.2), (2.1, 4.2), (2.2, 4.2)];
        let rows = rows.map(|(t_s, angle)| (t_s, [angle, -angle, f64::NAN]));
        let wheels = fixture::series(Sensor::WheelAngle, rows.to_vec(), 1e-3);
        let told = driven_by(&wheels).unwrap();
        let from_s: Vec<f64> = told.iter().map(|(t_s, _)| *t_s).collect();
        // two rows at one time lead nowhere
        assert_eq!(from_s, [0.0, 0.1, 2.1]);
        for ((_, command), speed) in told.iter().zip([2.0, 2.0, 0.0]) {
            let Command::Speed {
                right_rad_s,
                left_rad_s,
            } = command
            else {
                panic!("{command:?}")
            };
            assert!((right_rad_s - speed).abs() < 1e-12 && (left_rad_s + speed).abs() < 1e-12);
        }
    }

    fn long() -> Track {
        let rows = |count: u32| (0..count).map(|k| (f64::from(k), [0.0; 3])).collect();
        let series = vec![
            fixture::series(Sensor::WheelAngle, rows(1000), 1.0),
            fixture::series(Sensor::Pose, rows(90), 1.0),
        ];
        let none = Command::Torque {
            right_nm: 0.0,
            left_nm: 0.0,
        };
        fixture::track(vec![(0.0, none)], series)
    }

    #[test]
    fn only_what_is_too_long_is_thinned_and_evenly() {
        let mut track = long();
        track.thin(300);
        let stamps: Vec<f64> = track.series[0].rows.iter().map(|row| row.0).collect();
        assert_eq!(stamps.len(), 250);
        assert!(
            stamps
                .iter()
                .zip(0_u32..)
                .all(|(t_s, k)| *t_s == f64::from(4 * k))
        );
        assert_eq!(track.series[1].rows.len(), 90);
    }

    #[test]
    fn nothing_is_believed_of_times_left_out() {
        let mut track = long();
        track.leave_out(&[[10.0, 19.0], [80.0, 2000.0]]);
        assert_eq!(track.series[0].rows.len(), 70);
        let inside = |t_s: f64| (10.0..=19.0).contains(&t_s) || t_s >= 80.0;
        assert!(
            track
                .series
                .iter()
                .all(|s| !s.rows.iter().any(|row| inside(row.0)))
        );
        assert_eq!(track.span_s(), [0.0, 79.0]);
    }

    #[test]
    fn a_heading_that_turns_over_goes_on() {
        let seen = [3.0, -3.1, f64::NAN, -2.9, 3.1];
        let count = seen.len();
        let mut robot = Recorded::named("r1");
        robot.pose = Some(slipstream_recording::recording::Stream {
            t_s: (0_u32..).map(f64::from).take(count).collect(),
            values: Pose {
                x_m: vec![0.0; count],
                y_m: vec![0.0; count],
                yaw_rad: Some(seen.to_vec()),
            },
            unknown: vec![],
        });
        let yaw: Vec<f64> = poses(&robot).unwrap().rows.iter().map(|r| r.1[2]).collect();
        let steady = [3.0, TAU - 3.1, f64::NAN, TAU - 2.9, 3.1];
        for (own, wanted) in yaw.iter().zip(steady) {
            let same = (own - wanted).abs() < 1e-12 || own.is_nan() && wanted.is_nan();
            assert!(same, "{own} for {wanted}");
        }
    }
}
