//! Poses of a window predicted by its wheels.

use nalgebra::{Matrix3, Vector3};

use super::errors::Errors;
use super::prediction::{FITTED_S, Piece, rows_of};
use super::spread::{Spread, from_start};
use crate::data::wheel_path::Turned;
use crate::filter::arc::Carried;
use crate::filter::wrapped;
use crate::judge::{HEADING, PLACE, POSE};
use crate::model::wheel_parameters::pose_parameters;
use crate::predict::drawn::{Place, from_robot};

/// How often the time over which a start is fitted may be extended, how many poses it wants, and how many it needs with
/// a heading and without one.
const AT_MOST: usize = 5;
const SEEN: usize = 5;
const NEEDED: [usize; 2] = [1, 3];
/// Longest piece of an arc (s).
const PIECE_S: f64 = 0.1;

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
    of_stamp: [f64; 3],
}

/// The axle on its way from the start of a window.
struct AxleWalk<'a> {
    wheels: &'a dyn Turned<f64>,
    hint: usize,
    carried: Carried<'a, f64>,
    now_s: f64,
    angles: [f64; 2],
    /// Place (m), heading (rad), and what noise makes of both.
    place: [f64; 2],
    heading: f64,
    spread: Spread,
    /// Speed (m/s) and turn rate (rad/s).
    rates: [f64; 2],
}

impl AxleWalk<'_> {
    /// Goes on to a time (s), in arcs.
    fn to(&mut self, to_s: f64) {
        let pieces = ((to_s - self.now_s) / PIECE_S).ceil().max(1.0);
        let dt = (to_s - self.now_s) / pieces;
        for piece in 1..=(pieces as usize) {
            let t_s = self.now_s + (to_s - self.now_s) * piece as f64 / pieces;
            let next = self.wheels.angles_at(t_s, &mut self.hint);
            let turned = [0, 1].map(|i| next[i] - self.angles[i]);
            self.angles = next;
            self.arc(turned, dt);
        }
        self.now_s = to_s;
    }

    /// One arc, on which the wheels turn so far (rad) in `dt` (s).
    fn arc(&mut self, turned: [f64; 2], dt: f64) {
        let arc = self.carried.arc(turned, dt);
        self.spread.advance(arc.way, arc.turn, self.heading, dt);
        if dt > 0.0 {
            let [w, v] = arc.rates(dt);
            self.rates = [v, w];
        }
        let (sin, cos) = (self.heading + arc.turn / 2.0).sin_cos();
        self.place[0] += arc.chord_m() * cos;
        self.place[1] += arc.chord_m() * sin;
        self.heading += arc.turn;
    }
}

impl Piece<'_> {
    /// The walk through the window, whose clock began at `now_s`.
    fn walk(&self, p: &[f64], now_s: f64) -> AxleWalk<'_> {
        let machine = self.own.machine;
        let [radius_m, half_track_m] = [machine.wheel_radius_m, machine.half_track_m];
        let mut hint = 0;
        AxleWalk {
            wheels: self.wheels,
            angles: self.wheels.angles_at(now_s, &mut hint),
            hint,
            carried: Carried {
                metres_per_rad: [0, 1].map(|i| p[i].exp() * radius_m),
                track_m: p[2].exp() * 2.0 * half_track_m,
                law: Some(std::array::from_fn(|i| p[8 + i])),
                wheel_radius_m: radius_m,
                half_track_m,
                knots: &machine.knots,
            },
            now_s,
            place: [0.0; 2],
            heading: 0.0,
            spread: Spread::new(self.noise.pose, radius_m, half_track_m),
            rates: [0.0; 2],
        }
    }

    /// Poses of the window relative to the axle at its start.
    fn relative(&self) -> Vec<Relative> {
        let Some(pose) = &self.own.run.pose else {
            return Vec::new();
        };
        let p = pose_parameters(self.local);
        let offset = [p[3] + self.own.run.declared_m, p[4], p[5]];
        let time = |stamp_s: f64| (stamp_s - p[6]) / (1.0 + p[7]);
        let mut walk = self.walk(&p, time(self.span_s[0]));
        let row = |(stamp_s, measured): &(f64, [f64; 3])| {
            walk.to(time(*stamp_s));
            let (sin, cos) = walk.heading.sin_cos();
            let lever = [
                offset[0] * cos - offset[1] * sin,
                offset[0] * sin + offset[1] * cos,
            ];
            let [v, w] = walk.rates;
            let moved = [v * cos, v * sin, w];
            Relative {
                stamp_s: *stamp_s,
                time_s: walk.now_s,
                measured: *measured,
                point: [walk.place[0] + lever[0], walk.place[1] + lever[1]],
                yaw_rad: walk.heading + offset[2],
                covariance: walk.spread.of_point(lever),
                of_stamp: moved.map(|rate| self.noise.stamp_s2 * rate * rate),
            }
        };
        rows_of(&pose.all, self.span_s).map(row).collect()
    }

    /// Places and headings behind those that the start is fitted to.
    pub(super) fn poses(&self, errors: &mut Errors) {
        let rows = self.relative();
        let Some(head) = self.head(&rows) else { return };
        let sensor = [POSE, POSE + 2].map(|channel| self.own.deviations[channel]);
        let known = [0, 1].map(|i| sensor[i].max(self.noise.sensor[i]));
        let Some((start, covariance)) = fitted_start(&rows[..head], known) else {
            return;
        };
        let (sin, cos) = start[2].sin_cos();
        for (number, row) in rows.iter().enumerate() {
            let at = [
                start[0] + row.point[0] * cos - row.point[1] * sin,
                start[1] + row.point[0] * sin + row.point[1] * cos,
                start[2] + row.yaw_rad,
            ];
            errors.drawn.path.push(Place {
                t_s: row.stamp_s,
                seen: (row.measured[0], row.measured[1]),
                predicted: (at[0], at[1]),
            });
            if number >= head {
                let mut expected = from_start(&row.covariance, &covariance, start[2], row.point);
                for (i, own) in expected.iter_mut().enumerate() {
                    *own += self.noise.sensor[i / 2].powi(2) + row.of_stamp[i];
                }
                let gone = [0, 1, 2].map(|i| row.measured[i] - rows[0].measured[i]);
                self.add(row, at, gone, expected, errors);
            }
        }
    }

    /// Adds a row that is predicted `at` a pose with these variances; the robot has `gone` so far.
    fn add(
        &self,
        row: &Relative,
        at: [f64; 3],
        gone: [f64; 3],
        expected: [f64; 3],
        errors: &mut Errors,
    ) {
        let [place2, yaw2] = [POSE, POSE + 2].map(|channel| self.own.deviations[channel].powi(2));
        let [dx, dy] = [at[0] - row.measured[0], at[1] - row.measured[1]];
        let score = &mut errors.score;
        score.add(POSE, dx * dx, place2, expected[0]);
        score.add(POSE + 1, dy * dy, place2, expected[1]);
        let apart = dx.hypot(dy);
        let both = expected[0] + expected[1];
        score.add(PLACE, apart * apart, 2.0 * place2, both);
        let turned = wrapped(at[2] - row.measured[2]);
        let squares = [
            [gone[0].powi(2) + gone[1].powi(2), wrapped(gone[2]).powi(2)],
            [dx * dx + dy * dy, turned * turned],
            [2.0 * place2, yaw2],
        ];
        score.follow(self.own.machine.half_track_m, squares);
        if turned.is_finite() {
            score.add(HEADING, turned * turned, yaw2, expected[2]);
            errors.add((row.stamp_s, POSE + 2), turned, [yaw2, expected[2]]);
        }
        let seen = row.measured[2];
        let yaw_rad = if seen.is_finite() { seen } else { at[2] };
        for (part, error) in from_robot([dx, dy], yaw_rad).into_iter().enumerate() {
            errors.drawn.errors[POSE + part].push((row.stamp_s, error));
        }
    }

    /// How many of the first rows of a window its start is fitted to; `None` where nothing is left to predict.
    fn head(&self, rows: &[Relative]) -> Option<usize> {
        let has_heading = self.own.run.has_heading();
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
}

/// Pose of the axle at the start of a window and its covariance, by least squares over its first rows with
/// the noise of place (m) and yaw (rad).
fn fitted_start(rows: &[Relative], [place, yaw]: [f64; 2]) -> Option<([f64; 3], Matrix3<f64>)> {
    let (middle, point, heading) = turned(rows);
    let mut start = Vector3::new(middle[0], middle[1], heading);
    let (s, c) = heading.sin_cos();
    start[0] -= point[0] * c - point[1] * s;
    start[1] -= point[0] * s + point[1] * c;
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

/// The middles of measured and predicted places (m), and the heading (rad) that turns these to those: by the measured
/// headings, or else by the places alone (Procrustes).
fn turned(rows: &[Relative]) -> ([f64; 2], [f64; 2], f64) {
    let turns = rows
        .iter()
        .map(|row| row.measured[2] - row.yaw_rad)
        .filter(|turn| turn.is_finite());
    let (sin, cos) = turns.fold((0.0, 0.0), |(s, c), turn| (s + turn.sin(), c + turn.cos()));
    let mean = |of: &dyn Fn(&Relative) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
    let middle = [0, 1].map(|i| mean(&|row| row.measured[i]));
    let point = [0, 1].map(|i| mean(&|row| row.point[i]));
    if sin != 0.0 || cos != 0.0 {
        return (middle, point, f64::atan2(sin, cos));
    }
    let (mut dot, mut cross) = (0.0, 0.0);
    for row in rows {
        let a = [0, 1].map(|i| row.point[i] - point[i]);
        let b = [0, 1].map(|i| row.measured[i] - middle[i]);
        dot += a[0] * b[0] + a[1] * b[1];
        cross += a[0] * b[1] - a[1] * b[0];
    }
    (middle, point, f64::atan2(cross, dot))
}
