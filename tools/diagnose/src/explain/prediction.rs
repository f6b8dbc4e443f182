//! Prediction error in the units of the robot: windows of 5 s, the start of each fitted to its first
//! half second, the rest simulated from what drives the robot, the commands or else the wheels.

use nalgebra::{Matrix3, Vector3};

use super::fitted_noise::{NoiseOf, OfGyro};
use super::open_loop::HORIZON_S;
use super::spread::{Spread, from_start, of_stamp};
use crate::data::streams::WheelKind;
use crate::data::wheel_path::Turned;
use crate::filter::motion_law::{LAW, added, turning};
use crate::filter::wrapped;
use crate::judge::{GYRO, HEADING, PLACE, POSE, QUANTITIES, Score};
use crate::model::command_to_wheels::DriveRun;
use crate::model::drive::{AVERAGED, Response};
use crate::model::from_wheels::{
    FromWheels, MACHINE, RUN_BIAS, TURNS_FIRST, drive_parameters, gyro_parameters, pose_parameters,
};
use crate::model::run::{Run, sensor_noise};

/// Channels that are predicted.
pub(crate) const CHANNELS: [usize; 6] = [0, 1, POSE, POSE + 1, POSE + 2, GYRO];
/// Time over which the start of a window is fitted (s), how often that may be extended, how many poses it
/// wants, and how many it needs with a heading and without one.
const FITTED_S: f64 = 0.5;
const AT_MOST: usize = 5;
const SEEN: usize = 5;
const NEEDED: [usize; 2] = [1, 3];
/// Shortest window (s).
pub(crate) const SHORTEST_S: f64 = 1.0;
/// Most rows of a sensor that are predicted.
const MOST_ROWS: usize = 5000;
/// Most windows of a run by which two models are compared.
const MOST_WINDOWS: usize = 40;
/// Rows of a window that are predicted however long the recording is.
const LEAST_ROWS: usize = 50;
/// Longest piece of an arc (s).
const PIECE_S: f64 = 0.1;

/// What a run is predicted by.
pub(crate) struct Predictor<'a> {
    pub(crate) machine: &'a FromWheels,
    pub(crate) run: &'a Run,
    /// Commands and wheels, where both were recorded.
    pub(crate) drive: Option<&'a DriveRun>,
    /// Standard deviations of the sensors, channel by channel.
    pub(crate) deviations: [f64; QUANTITIES],
    /// Noise sizes by which the error is predicted; without them that of the sensors alone is.
    pub(crate) noise: Option<Noise<'a>>,
}

/// Fitted noise sizes of a run.
#[derive(Clone, Copy)]
pub(crate) struct Noise<'a> {
    /// All parameters of the machine as they were fitted.
    pub(crate) at: &'a [f64],
    /// Logarithms of the noise sizes of the drive.
    pub(crate) drive: Option<&'a [f64]>,
}

/// What a run scores, and a place on the way to draw.
#[derive(Debug, Clone, Default)]
pub(crate) struct Errors {
    pub(crate) score: Score,
    /// Begin, end (s) and score of each window.
    pub(crate) windows: Vec<([f64; 2], Score)>,
    /// Where the robot was seen and where it is predicted (m), a gap after each window.
    pub(crate) seen: Vec<(f64, f64)>,
    pub(crate) predicted: Vec<(f64, f64)>,
    /// Time (s), channel, and predicted minus measured, places as seen from the robot; not finite behind
    /// each window.
    pub(crate) residuals: Vec<(f64, usize, f64)>,
}

/// A row of the pose in the frame of the window's start.
struct Relative {
    stamp_s: f64,
    time_s: f64,
    measured: [f64; 3],
    /// The tracked point and the measured yaw, relative to the axle at the start.
    point: [f64; 2],
    yaw_rad: f64,
    /// Covariance of both, and what an error of the stamp adds.
    covariance: Matrix3<f64>,
    of_stamp: Vector3<f64>,
}

impl Errors {
    /// Adds a row: its error, and the variances of its sensor and of all noise.
    fn add(&mut self, channel: usize, residual: f64, sensor: f64, expected: f64) {
        self.score
            .add(channel, residual * residual, sensor, expected);
    }

    /// Draws a place error as seen from a robot that heads for `yaw_rad`.
    fn draw_place(&mut self, stamp_s: f64, [dx, dy]: [f64; 2], yaw_rad: f64) {
        let (sin, cos) = yaw_rad.sin_cos();
        self.residuals.push((stamp_s, POSE, dx * cos + dy * sin));
        self.residuals
            .push((stamp_s, POSE + 1, dy * cos - dx * sin));
    }

    /// A gap behind what was drawn of a window.
    fn draw_gap(&mut self, stamp_s: f64) {
        let gaps = CHANNELS.map(|channel| (stamp_s, channel, f64::NAN));
        self.residuals.extend(gaps);
    }

    /// Both together.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.score = self.score.and(&other.score);
        self.windows.extend(other.windows);
        self.seen.extend(other.seen);
        self.predicted.extend(other.predicted);
        self.residuals.extend(other.residuals);
        self
    }
}

impl Predictor<'_> {
    /// Begin and end of the windows (s).
    pub(crate) fn windows(&self) -> Vec<[f64; 2]> {
        let [from_s, to_s] = self.run.blocks.span_s;
        let count = ((to_s - from_s) / HORIZON_S).ceil().max(1.0) as usize;
        let all = (0..count).map(|k| {
            let begin = from_s + HORIZON_S * k as f64;
            [begin, (begin + HORIZON_S).min(to_s)]
        });
        all.filter(|[a, b]| b - a >= SHORTEST_S).collect()
    }

    /// Predicts these windows by the parameters `at` of the machine, of run number `number`.
    pub(crate) fn errors(
        &self,
        number: usize,
        at: &[f64],
        windows: &[[f64; 2]],
        draw: bool,
    ) -> Errors {
        let local = self.machine.local(number, at);
        let noise = self.noise.map(|noise| {
            let local = self.machine.local(number, noise.at);
            let turn_per_wheel = self.machine.wheel_radius_m / self.machine.half_track_m;
            NoiseOf::new(self.run, &local, noise.drive, turn_per_wheel)
        });
        let noise = noise.unwrap_or_default();
        let each = |wheels: &dyn Turned<f64>| {
            let one = |window: &[f64; 2]| {
                let mut errors = Errors::default();
                self.poses(&local, &noise, wheels, *window, &mut errors, draw);
                self.rates(&local, &noise, wheels, *window, &mut errors, draw);
                errors
            };
            windows.iter().map(one).collect::<Vec<Errors>>()
        };
        let mut each = match self.drive {
            None => self.run.wheels.turned(drive_parameters(&local), each),
            Some(drive) => {
                let response = Response::new(&drive.commands, drive_parameters(&local));
                let over_s = drive_parameters(&local)[AVERAGED];
                let mut each = each(&response);
                for (window, errors) in windows.iter().zip(&mut each) {
                    self.wheels(drive, &noise, (&response, over_s), *window, errors, draw);
                }
                each
            }
        };
        for (window, errors) in windows.iter().zip(&mut each) {
            if draw {
                errors.draw_gap(window[1]);
            }
            errors.windows = vec![(*window, errors.score)];
        }
        each.into_iter().fold(Errors::default(), Errors::and)
    }

    /// Poses of a window relative to the axle at its start.
    fn relative(
        &self,
        local: &[f64],
        noise: &NoiseOf,
        wheels: &dyn Turned<f64>,
        window: [f64; 2],
    ) -> Vec<Relative> {
        let Some(pose) = &self.run.pose else {
            return Vec::new();
        };
        let mut spread = Spread::new(
            noise.pose,
            self.machine.wheel_radius_m,
            self.machine.half_track_m,
        );
        let mut rates = [0.0; 2];
        let p = pose_parameters(local);
        let metres = [0, 1].map(|i| p[i].exp() * self.machine.wheel_radius_m);
        let track_m = p[2].exp() * 2.0 * self.machine.half_track_m;
        let offset = [p[3] + self.run.declared_m, p[4], p[5]];
        let law: [f64; LAW] = std::array::from_fn(|i| p[8 + i]);
        let first = pose.all.partition_point(|(t_s, _)| *t_s < window[0]);
        let end = pose.all.partition_point(|(t_s, _)| *t_s < window[1]);
        let stride = stride(pose.all.len(), end - first);
        let mut hint = 0;
        let time = |stamp_s: f64| (stamp_s - p[6]) / (1.0 + p[7]);
        let mut now_s = time(window[0]);
        let mut angles = wheels.angles_at(now_s, &mut hint);
        let [mut x, mut y, mut heading] = [0.0_f64; 3];
        let mut rows = Vec::new();
        for (stamp_s, measured) in pose.all[first..end].iter().step_by(stride) {
            let to_s = time(*stamp_s);
            let pieces = ((to_s - now_s) / PIECE_S).ceil().max(1.0);
            for piece in 1..=(pieces as usize) {
                let t_s = now_s + (to_s - now_s) * piece as f64 / pieces;
                let next = wheels.angles_at(t_s, &mut hint);
                let turned = [0, 1].map(|i| next[i] - angles[i]);
                let [right, left] = [0, 1].map(|i| metres[i] * turned[i]);
                angles = next;
                let dt = (to_s - now_s) / pieces;
                let r = self.machine.wheel_radius_m / 2.0;
                let nominal_way = r * (turned[0] + turned[1]);
                let nominal_turn = r * (turned[0] - turned[1]) / self.machine.half_track_m;
                let [v, w] = if dt > 1e-9 {
                    let drivers = [nominal_turn / dt, nominal_way / dt];
                    added(&law, drivers, &self.machine.knots)
                } else {
                    [0.0; 2]
                };
                let way = f64::midpoint(right, left) + v * dt;
                let turn = (right - left) / track_m + w * dt;
                spread.advance(way, turn, heading, dt);
                if dt > 1e-9 {
                    rates = [way / dt, turn / dt];
                }
                let chord = way * (1.0 - turn * turn / 24.0);
                let (sin, cos) = (heading + turn / 2.0).sin_cos();
                (x, y, heading) = (x + chord * cos, y + chord * sin, heading + turn);
            }
            now_s = to_s;
            let (sin, cos) = heading.sin_cos();
            let lever = [
                offset[0] * cos - offset[1] * sin,
                offset[0] * sin + offset[1] * cos,
            ];
            let [v, w] = rates;
            rows.push(Relative {
                stamp_s: *stamp_s,
                time_s: to_s,
                measured: *measured,
                point: [x + lever[0], y + lever[1]],
                yaw_rad: heading + offset[2],
                covariance: spread.of_point(lever),
                of_stamp: of_stamp(noise.stamp_s2, [v * cos, v * sin, w]),
            });
        }
        rows
    }

    fn poses(
        &self,
        local: &[f64],
        noise: &NoiseOf,
        wheels: &dyn Turned<f64>,
        window: [f64; 2],
        errors: &mut Errors,
        draw: bool,
    ) {
        let rows = self.relative(local, noise, wheels, window);
        let Some(head) = self.head(&rows) else { return };
        let sensor = [POSE, POSE + 2].map(|channel| self.deviations[channel]);
        let known = [0, 1].map(|i| sensor[i].max(noise.sensor[i]));
        let Some((start, covariance)) = fitted_start(&rows[..head], known) else {
            return;
        };
        let (sin, cos) = start[2].sin_cos();
        for (place, row) in rows.iter().enumerate() {
            let at = [
                start[0] + row.point[0] * cos - row.point[1] * sin,
                start[1] + row.point[0] * sin + row.point[1] * cos,
            ];
            if draw {
                errors.seen.push((row.measured[0], row.measured[1]));
                errors.predicted.push((at[0], at[1]));
            }
            if place < head {
                continue;
            }
            let mut expected = from_start(&row.covariance, &covariance, start[2], row.point);
            for (i, own) in expected.iter_mut().enumerate() {
                *own += noise.sensor[i / 2].powi(2) + row.of_stamp[i];
            }
            let [dx, dy] = [at[0] - row.measured[0], at[1] - row.measured[1]];
            let [place2, yaw2] = sensor.map(|own| own * own);
            errors.add(POSE, dx, place2, expected[0]);
            errors.add(POSE + 1, dy, place2, expected[1]);
            errors.add(PLACE, dx.hypot(dy), 2.0 * place2, expected[0] + expected[1]);
            if draw {
                let heading = start[2] + row.yaw_rad;
                let seen = row.measured[2];
                let yaw_rad = if seen.is_finite() { seen } else { heading };
                errors.draw_place(row.stamp_s, [dx, dy], yaw_rad);
            }
            let turned = wrapped(start[2] + row.yaw_rad - row.measured[2]);
            let gone = [0, 1, 2].map(|i| row.measured[i] - rows[0].measured[i]);
            let squares = [
                [gone[0].powi(2) + gone[1].powi(2), wrapped(gone[2]).powi(2)],
                [dx * dx + dy * dy, turned * turned],
                [2.0 * place2, yaw2],
            ];
            let half_track_m = self.machine.half_track_m;
            errors.score.follow(half_track_m, squares);
            if turned.is_finite() {
                errors.add(HEADING, turned, yaw2, expected[2]);
                errors.add(POSE + 2, turned, yaw2, expected[2]);
                if draw {
                    errors.residuals.push((row.stamp_s, POSE + 2, turned));
                }
            }
        }
        if draw {
            errors.seen.push((f64::NAN, f64::NAN));
            errors.predicted.push((f64::NAN, f64::NAN));
        }
    }

    /// How many of the first rows of a window its start is fitted to; `None` where nothing is left to predict.
    fn head(&self, rows: &[Relative]) -> Option<usize> {
        let has_heading = self.run.has_heading();
        let from_s = rows.first()?.time_s;
        // without a heading the first turn of the way has to show it
        let least = if has_heading { 1 } else { AT_MOST - 1 };
        let counts = (least..=AT_MOST).map(|times| {
            let until_s = from_s + FITTED_S * times as f64;
            rows.partition_point(|row| row.time_s <= until_s)
        });
        let counts: Vec<usize> = counts.collect();
        let wanted = counts.iter().copied().find(|count| *count >= SEEN);
        let needed = NEEDED[usize::from(!has_heading)];
        let head = wanted.or_else(|| counts.last().copied().filter(|count| *count >= needed))?;
        (head < rows.len()).then_some(head)
    }

    /// Turn rates of a window, and the heading by their integral where no pose has it.
    fn rates(
        &self,
        local: &[f64],
        noise: &NoiseOf,
        wheels: &dyn Turned<f64>,
        window: [f64; 2],
        errors: &mut Errors,
        draw: bool,
    ) {
        let Some(gyro) = &self.run.gyro else { return };
        let p = gyro_parameters(local);
        let metres = [0, 1].map(|i| p[i].exp() * self.machine.wheel_radius_m);
        let track_m = p[2].exp() * 2.0 * self.machine.half_track_m;
        let bias = local[MACHINE + RUN_BIAS];
        let law = &local[TURNS_FIRST..MACHINE];
        let first = gyro.all.partition_point(|(t_s, _)| *t_s < window[0]);
        let end = gyro.all.partition_point(|(t_s, _)| *t_s < window[1]);
        let stride = stride(gyro.all.len(), end - first);
        let rows: Vec<(f64, f64)> = gyro.all[first..end]
            .iter()
            .step_by(stride)
            .copied()
            .collect();
        let half_s = self.run.wheel_interval_s / 2.0;
        let sensor = self.deviations[GYRO].powi(2);
        let mut hint = 0;
        let mut heading = 0.0;
        let mut spread = OfGyro::default();
        let mut last: Option<(f64, f64, f64)> = None;
        for (stamp_s, rate) in rows {
            let t_s = (stamp_s - p[3]) / (1.0 + p[4]);
            let before = wheels.angles_at(t_s - half_s, &mut hint);
            let after = wheels.angles_at(t_s + half_s, &mut hint);
            let turned = [0, 1].map(|i| after[i] - before[i]);
            let [right, left] = [0, 1].map(|i| metres[i] * turned[i]);
            let nominal = (turned[0] - turned[1]) * self.machine.wheel_radius_m
                / (2.0 * self.machine.half_track_m * 2.0 * half_s);
            let turning = (right - left) / track_m / (2.0 * half_s)
                + turning(law, nominal, &self.machine.knots[0]);
            let residual = turning + bias - rate;
            if stamp_s < window[0] + FITTED_S || !residual.is_finite() {
                continue;
            }
            let speed = f64::midpoint(right, left) / (2.0 * half_s);
            let dt = last.map_or(0.0, |(last_s, ..)| stamp_s - last_s);
            let jerk = last.map_or(
                0.0,
                |(_, _, last)| {
                    if dt > 0.0 { (rate - last) / dt } else { 0.0 }
                },
            );
            let of_rate =
                spread.advance(&noise.gyro, self.machine.half_track_m, [speed, turning], dt);
            let of_stamp = noise.gyro.stamp_s2 * jerk * jerk;
            // the turn of the wheels between two of their rows, both of which are rounded
            let of_wheels = 2.0 * noise.gyro.angle / (2.0 * half_s).powi(2);
            let expected = sensor + of_rate + of_stamp + of_wheels;
            errors.add(GYRO, residual, sensor, expected);
            if draw {
                errors.residuals.push((stamp_s, GYRO, residual));
            }
            if let Some((_, last, _)) = last {
                heading += dt * f64::midpoint(last, residual);
            }
            last = Some((stamp_s, residual, rate));
            if self.run.pose.is_none() {
                let of_sensor = sensor * dt * dt;
                let expected = spread.heading
                    + noise.gyro.angle
                    + 2.0 * noise.gyro.stamp_s2 * turning * turning;
                errors.add(HEADING, heading, of_sensor.max(1e-12), expected);
            }
        }
    }

    /// Wheels of a window simulated from the commands; speeds as means over so long (s).
    fn wheels(
        &self,
        drive: &DriveRun,
        noise: &NoiseOf,
        (response, over_s): (&Response<'_, f64>, f64),
        window: [f64; 2],
        errors: &mut Errors,
        draw: bool,
    ) {
        let rows = &drive.wheels.rows;
        let first = rows.partition_point(|row| row.time_s < window[0]);
        let end = rows.partition_point(|row| row.time_s < window[1]);
        let is_angle = drive.wheels.kind == WheelKind::Angle;
        let mut hint = 0;
        let rests: Vec<(f64, [f64; 2], [f64; 2])> = rows[first..end]
            .iter()
            .map(|row| {
                let now = response.averaged(row.time_s, over_s, &mut hint);
                let value = if is_angle {
                    now.angle_rad
                } else {
                    now.speed_rad_s
                };
                let rest = [0, 1].map(|i| value[i] - row.values[i]);
                (row.time_s, rest, now.speed_rad_s)
            })
            .collect();
        let head = rests.partition_point(|(t_s, ..)| *t_s < window[0] + FITTED_S);
        if is_angle && head == 0 {
            return;
        }
        let zero = [0, 1].map(|i| {
            let all = rests[..head].iter().map(|(_, rest, _)| rest[i]);
            if is_angle {
                all.sum::<f64>() / head as f64
            } else {
                0.0
            }
        });
        let known = 1.0 + 1.0 / head.max(1) as f64;
        let start = rows.get(first).filter(|_| is_angle);
        let zeros = start.map_or([0.0; 2], |row| row.values);
        for ((t_s, rest, speed), row) in rests[head..].iter().zip(&rows[first + head..end]) {
            let gone = [0, 1].map(|i| row.values[i] - zeros[i]);
            // the zero is the mean over the head: its middle is where the disturbance begins to count
            let over_s = t_s - window[0] - FITTED_S / 2.0;
            for i in 0..2 {
                let sensor = self.deviations[i].powi(2);
                let own = noise.wheels.variance(is_angle, over_s, speed[i]);
                let error = rest[i] - zero[i];
                if self.run.pose.is_none() {
                    let squares = [gone[i] * gone[i], error * error, sensor];
                    errors.score.follow_wheel(squares);
                }
                errors.add(
                    i,
                    error,
                    sensor,
                    own + sensor.max(noise.wheels.sensor2) * known,
                );
                if draw {
                    errors.residuals.push((*t_s, i, error));
                }
            }
        }
    }
}

/// Error of predictions by the wheels of a machine with these parameters: geometric mean of place (m) and
/// heading (rad), of those that are seen.
pub(super) fn reference_error(machine: &FromWheels, at: &[f64]) -> f64 {
    let today = machine.runs.iter().enumerate().skip(machine.before.runs);
    let all = today.map(|(number, run)| {
        let predictor = Predictor {
            machine,
            run,
            drive: None,
            deviations: [1.0; QUANTITIES],
            noise: None,
        };
        let windows = predictor.windows();
        let stride = windows.len().div_ceil(MOST_WINDOWS).max(1);
        let windows: Vec<[f64; 2]> = windows.into_iter().step_by(stride).collect();
        predictor.errors(number, at, &windows, false)
    });
    let sum = all.fold(Errors::default(), Errors::and);
    let [place, heading] = [PLACE, HEADING].map(|quantity| sum.score.mean_square(quantity));
    match (place, heading) {
        (Some(place), Some(heading)) => (place * heading).powf(0.25),
        (Some(one), None) | (None, Some(one)) => one.sqrt(),
        (None, None) => 0.0,
    }
}

/// Standard deviations of the sensors of a run, channel by channel.
pub(crate) fn deviations(
    run: &Run,
    drive: Option<&DriveRun>,
    declared: &slipstream_recording::recording::Noise,
) -> [f64; QUANTITIES] {
    let [place, yaw] = run.pose.as_ref().map_or([1.0; 2], |p| sensor_noise(&p.all));
    let wheels = drive.map_or(1.0, |drive| {
        drive
            .wheels
            .rounding_rad
            .max(declared.wheel_rad.unwrap_or(1e-4))
    });
    let place = declared.pose_m.unwrap_or(place);
    let yaw = declared.pose_rad.unwrap_or(yaw);
    let gyro = declared.imu_rad_s.unwrap_or_else(|| {
        let rows = run.gyro.as_ref().map_or(&[][..], |gyro| &gyro.all);
        let mut steps: Vec<f64> = rows.windows(2).map(|w| (w[1].1 - w[0].1).abs()).collect();
        steps.sort_by(f64::total_cmp);
        let median = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
        (median / 0.67 / 2.0_f64.sqrt()).max(1e-4)
    });
    let mut all = [1.0; QUANTITIES];
    all[..POSE].fill(wheels);
    all[POSE..=POSE + 1].fill(place);
    all[POSE + 2] = yaw;
    all[GYRO] = gyro;
    all
}

/// Every how manieth row of a window of so many is predicted, of `all` rows of the recording.
fn stride(all: usize, window: usize) -> usize {
    let wanted = all.div_ceil(MOST_ROWS);
    wanted.min(window / LEAST_ROWS).max(1)
}

/// Pose of the axle at the start of a window and its covariance, by least squares over its first rows with
/// the noise of place (m) and yaw (rad).
fn fitted_start(rows: &[Relative], [place, yaw]: [f64; 2]) -> Option<([f64; 3], Matrix3<f64>)> {
    let turns = rows
        .iter()
        .map(|row| row.measured[2] - row.yaw_rad)
        .filter(|turn| turn.is_finite());
    let (sin, cos) = turns.fold((0.0, 0.0), |(s, c), turn| (s + turn.sin(), c + turn.cos()));
    let mean = |of: &dyn Fn(&Relative) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
    let [mx, my] = [mean(&|r| r.measured[0]), mean(&|r| r.measured[1])];
    let [px, py] = [mean(&|r| r.point[0]), mean(&|r| r.point[1])];
    let heading = if sin == 0.0 && cos == 0.0 {
        // Procrustes
        let (mut dot, mut cross) = (0.0, 0.0);
        for row in rows {
            let a = [row.point[0] - px, row.point[1] - py];
            let b = [row.measured[0] - mx, row.measured[1] - my];
            dot += a[0] * b[0] + a[1] * b[1];
            cross += a[0] * b[1] - a[1] * b[0];
        }
        f64::atan2(cross, dot)
    } else {
        f64::atan2(sin, cos)
    };
    let mut start = Vector3::new(mx, my, heading);
    let (s, c) = heading.sin_cos();
    start[0] -= px * c - py * s;
    start[1] -= px * s + py * c;
    let mut covariance = Matrix3::zeros();
    for _ in 0..4 {
        let (mut information, mut gradient) = (Matrix3::zeros(), Vector3::zeros());
        let (s, c) = start[2].sin_cos();
        for row in rows {
            let turned = [
                row.point[0] * c - row.point[1] * s,
                row.point[0] * s + row.point[1] * c,
            ];
            let lines = [
                (
                    Vector3::new(1.0, 0.0, -turned[1]) / place,
                    (row.measured[0] - start[0] - turned[0]) / place,
                ),
                (
                    Vector3::new(0.0, 1.0, turned[0]) / place,
                    (row.measured[1] - start[1] - turned[1]) / place,
                ),
                (
                    Vector3::new(0.0, 0.0, 1.0) / yaw,
                    wrapped(row.measured[2] - start[2] - row.yaw_rad) / yaw,
                ),
            ];
            for (line, rest) in lines {
                if rest.is_finite() {
                    information += line * line.transpose();
                    gradient += line * rest;
                }
            }
        }
        let factor = information.cholesky()?;
        start += factor.solve(&gradient);
        covariance = factor.inverse();
    }
    let finite = start.iter().all(|v| v.is_finite());
    finite.then(|| (start.into(), covariance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_of_a_long_recording_keeps_its_rows() {
        assert_eq!(stride(900, 150), 1);
        assert_eq!(stride(108_002, 150), 3);
        assert_eq!(stride(3_600_000, 5000), 100);
        assert_eq!(stride(3_600_000, 20), 1);
    }
}
