//! From wheel angles to pose and gyro, for one machine in one or several runs.
//!
//! The machine has one geometry, one mounting of its reference and one set of clocks. Floor and load
//! belong to a run: how far it is carried for a turn of its wheels, and its effective track.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::Robot;

use super::command_to_wheels::drive_of;
use super::comparison::{self, Before, SHARES};
use super::crude;
use super::drive::DRIVE;
use super::nominal::{self, clock_rate};
use super::run::{RUN_NOISE, Run, Source};
use super::volts::{self, Volts};
use super::wheel_parameters::{
    ASYMMETRY, COMMON, DRIVE_FIRST, GYRO_LATENCY, GYRO_RATE, LAW_FIRST, MACHINE, OFFSET_X,
    OFFSET_Y, OFFSET_YAW, POSE_LATENCY, POSE_RATE, RUN, RUN_POSE_LATE, RUN_SCALE, RUN_SHARED,
    TRACK, drive_parameters, pose_parameters,
};
use crate::data::matched::{Stamps, shift_against};
use crate::data::reference::{POSE_STEP_S, PoseRow, match_poses, match_rates};
use crate::data::streams::has_headings_alone;
use crate::filter::gyro as gyro_filter;
use crate::filter::motion_law::{Knots, TABLES};
use crate::filter::wheels_to_pose::{self, WheelsToPose};

/// Values of a law, as a share of the fastest speed of a rim, or of the largest turn rate.
const LAW_SHARE: f64 = 0.3;

/// Speed of a wheel about the middle, as a share of the robot's, below which a robot drives straight: what it loses then is
/// no loss in turns, and turns do not tell whose clock is late.
const LEAST_TURN: f64 = 0.1;

/// A robot that never turns farther than this drives straight (rad): the pull of a slope is then within a tenth of what it
/// was at first.
const STRAIGHT_RAD: f64 = 0.45;

/// The machine.
#[derive(Debug, Clone)]
pub(crate) struct FromWheels {
    pub(crate) runs: Vec<Run>,
    pub(crate) wheel_radius_m: f64,
    pub(crate) half_track_m: f64,
    /// From the middle of the axle forward to the centre of mass (m).
    pub(crate) com_to_axle_m: f64,
    /// Knots of laws over turn rate (rad/s) and speed (m/s).
    pub(crate) knots: [Knots; 2],
    /// Crude logarithm of the way of the reference over that of the wheels, where it is beyond a factor of 2;
    /// else 0.
    pub(crate) crude_scale: f64,
    /// Whether it steers by skidding: its effective track is then that of the floor.
    pub(crate) skids: bool,
    /// Whether its gyro is the heading of its poses, which have no place.
    pub(crate) by_heading: bool,
    /// The motors, where they are told voltages.
    pub(crate) volts: Option<Volts>,
    /// What it is compared with.
    pub(crate) before: Before,
    /// How far the logarithms of scale and track of each run were from the model's on its course before.
    pub(crate) offsets: Vec<[f64; 2]>,
}

impl FromWheels {
    /// The machine of these runs; `None` without a run that has wheels and a reference.
    pub(crate) fn new(
        robots: &[&Robot],
        model: &RobotModel,
        excluded_s: &[[f64; 2]],
    ) -> Option<Self> {
        let b = model.robot.half_track_m;
        let mut machine = Self {
            runs: Vec::new(),
            wheel_radius_m: model.robot.wheel_radius_m,
            half_track_m: b,
            com_to_axle_m: model.robot.com_to_axle_m.unwrap_or(0.0),
            knots: [Knots::default(); 2],
            crude_scale: 0.0,
            skids: robots.iter().any(|robot| skids(robot)),
            by_heading: robots.iter().any(|robot| has_headings_alone(robot)),
            volts: volts::of(robots, model),
            before: Before::default(),
            offsets: Vec::new(),
        };
        let mut first_block = 0;
        for (at, robot) in robots.iter().enumerate() {
            if let Some(mut run) = Run::new(robot, model, excluded_s, first_block) {
                run.robot = at;
                first_block = run.blocks.end();
                machine.runs.push(run);
            }
        }
        for i in 0..machine.runs.len() {
            machine.runs[i].first_heading_rad = machine.first_heading(&machine.runs[i]);
        }
        machine.crude_scale = crude::scale_ln(&machine.runs, machine.wheel_radius_m);
        let mut ranges = [[0.0_f64; 2]; 2];
        for run in &machine.runs {
            let [w, v] = run.wheels.ranges_rad_s();
            let r = machine.wheel_radius_m;
            let own = [w.map(|w| w * r / machine.half_track_m), v.map(|v| v * r)];
            for (range, own) in ranges.iter_mut().zip(own) {
                *range = [range[0].min(own[0]), range[1].max(own[1])];
            }
        }
        machine.knots = ranges.map(Knots::over);
        (!machine.runs.is_empty()).then_some(machine)
    }

    /// How large the values of laws may plausibly be: of speed a share of the fastest rim (m/s), of turns a share
    /// of the largest turn rate (rad/s).
    pub(crate) fn law_priors(&self) -> [f64; 2] {
        let [w, v] = self.knots.map(|knots| knots.reach());
        [v.max(w * self.half_track_m), w].map(|most| LAW_SHARE * most)
    }

    /// Whether it turns beside driving straight.
    pub(crate) fn turns(&self) -> bool {
        let [w, v] = self.knots.map(|knots| knots.reach());
        w * self.half_track_m > LEAST_TURN * v
    }

    /// Whether it faces one way all the time.
    pub(crate) fn keeps_heading(&self) -> bool {
        let turn = self.wheel_radius_m / (2.0 * self.half_track_m);
        let mut runs = self.runs.iter();
        runs.all(|run| turn * run.wheels.most_turned_rad() < STRAIGHT_RAD)
    }

    /// Number of parameters, noise sizes included.
    pub(crate) fn parameters(&self) -> usize {
        let shared = if self.before.any() {
            MACHINE + SHARES
        } else {
            0
        };
        self.shared(shared)
    }

    /// Index of the share that runs from before and of today do not have in common, of one reference.
    pub(crate) fn share(&self, reference: Reference) -> usize {
        self.shared(MACHINE) + reference as usize
    }

    /// Index of a parameter of the machine that runs from before share with those of today.
    pub(crate) fn shared(&self, parameter: usize) -> usize {
        MACHINE + self.runs.len() * (RUN + RUN_NOISE) + parameter
    }

    /// Compares runs of today with those from before; `robots` are those of all.
    pub(crate) fn compare(&mut self, before: Before, robots: &[&Robot]) {
        let runs = self.runs.iter().map(|run| (run.blocks, run.course()));
        let clusters = comparison::clusters(before.runs, &runs.collect::<Vec<_>>());
        let (then, now) = self.runs.split_at_mut(before.runs);
        let mut stamped = [[0.0; 2]; SHARES];
        let clusters = clusters.filter(|_| {
            let mut pairs = then.iter_mut().zip(now);
            pairs.all(|(a, b)| match_runs([a, b], robots, &mut stamped))
        });
        self.before = Before {
            clusters,
            stamped,
            ..before
        };
    }

    /// The same machine with its runs of today alone.
    pub(crate) fn today(&self) -> Self {
        let mut today = self.clone();
        today.runs.drain(..self.before.runs);
        today.before = Before::default();
        let mut first = 0;
        for run in &mut today.runs {
            run.blocks.first = first;
            first = run.blocks.end();
            run.robot -= self.before.robots;
        }
        today
    }

    /// Index of a parameter of a run.
    pub(crate) fn of_run(&self, run: usize, parameter: usize) -> usize {
        MACHINE + run * (RUN + RUN_NOISE) + parameter
    }

    /// Indices of the noise sizes of streams that are there.
    pub(crate) fn noise(&self) -> Vec<usize> {
        let of = |i: usize, run: &Run| {
            let first = self.of_run(i, RUN);
            let pose = if run.pose.is_some() {
                wheels_to_pose::NOISE
            } else {
                0
            };
            let gyro = if run.gyro.is_some() {
                gyro_filter::NOISE
            } else {
                0
            };
            let second = first + wheels_to_pose::NOISE;
            (first..first + pose)
                .chain(second..second + gyro)
                .collect::<Vec<_>>()
        };
        let own = self.runs.iter().enumerate().flat_map(|(i, run)| of(i, run));
        own.chain(self.shares().map(|reference| self.share(reference)))
            .collect()
    }

    /// References that are compared row by row.
    pub(crate) fn shares(&self) -> impl Iterator<Item = Reference> + '_ {
        let paired = self.before.is_paired();
        Reference::ALL.into_iter().filter(move |own| {
            paired
                && match own {
                    Reference::Pose => self.has_pose(),
                    Reference::Gyro => self.has_gyro(),
                }
        })
    }

    /// Whether wheels turn as commanded, for none were recorded.
    pub(crate) fn is_commanded(&self) -> bool {
        self.runs.iter().any(|run| run.wheels.is_commanded())
    }

    /// Largest commanded wheel speed (rad/s), where wheels turn as commanded.
    pub(crate) fn largest_rad_s(&self) -> f64 {
        let each = self.runs.iter().map(|run| match &run.wheels {
            Source::Measured(_) => 0.0,
            Source::Commanded(path) => path.largest_rad_s(),
        });
        each.fold(0.0, f64::max).max(1e-3)
    }

    /// Whether every run's gyro may have a clock of its own: several runs, and nothing else to tell.
    pub(crate) fn has_clocks_of_runs(&self) -> bool {
        let today = self.runs.len() - self.before.runs;
        today.max(self.before.runs) > 1 && self.has_gyro() && !self.has_pose() && self.turns()
    }

    pub(crate) fn has_pose(&self) -> bool {
        self.runs.iter().any(|run| run.pose.is_some())
    }

    pub(crate) fn has_gyro(&self) -> bool {
        self.runs.iter().any(|run| run.gyro.is_some())
    }

    pub(crate) fn has_heading(&self) -> bool {
        self.runs.iter().any(Run::has_heading)
    }

    /// Deviations of speed (m/s) and turn rate (rad/s) from what the wheels say, over the time between
    /// the rows of a thinned series, at the mean speed; the largest of all runs.
    pub(crate) fn process_noise(&self, at: &[f64]) -> [f64; 2] {
        let mut most = [0.0_f64; 2];
        for (i, run) in self
            .runs
            .iter()
            .enumerate()
            .filter(|(_, run)| run.pose.is_some())
        {
            let first = self.of_run(i, RUN);
            let size = |k: usize| at[first + k].exp();
            let [from_s, to_s] = run.blocks.span_s;
            let way_m = run.wheels.turned_rad() * self.wheel_radius_m / 2.0;
            let speed = way_m / (to_s - from_s).max(1.0);
            let root = (speed / POSE_STEP_S).sqrt();
            most = [most[0].max(size(0) * root), most[1].max(size(2) * root)];
        }
        most
    }

    /// Values of all parameters in the nominal model, with first guesses of the noise sizes.
    pub(crate) fn nominal(&self, model: &RobotModel) -> Vec<f64> {
        let mut at = vec![0.0; self.parameters()];
        let factor = |effect: &str, name: &str| model.number(effect, name).unwrap_or(1.0).ln();
        let plain = |effect: &str, name: &str| model.number(effect, name).unwrap_or(0.0);
        let [right, left] = ["right_scale", "left_scale"]
            .map(|name| factor("wheel_radius", name) - factor("encoder_scale", name));
        at[COMMON] = (right + left) / 2.0;
        at[ASYMMETRY] = right - left;
        at[TRACK] = factor("track_width", "scale");
        at[OFFSET_X] = plain("pose_offset", "x_m");
        at[OFFSET_Y] = plain("pose_offset", "y_m");
        at[OFFSET_YAW] = plain("pose_offset", "yaw_rad");
        let wheels_s = plain("wheels_latency", "latency_s");
        let gyro = if self.by_heading { "pose" } else { "imu" };
        at[POSE_LATENCY] = plain("pose_latency", "latency_s") - wheels_s;
        at[GYRO_LATENCY] = plain(&format!("{gyro}_latency"), "latency_s") - wheels_s;
        let rate = |stream: &str| clock_rate(model, stream).unwrap_or(0.0);
        at[POSE_RATE] = rate("pose") - rate("wheels");
        at[GYRO_RATE] = rate(gyro) - rate("wheels");
        at[DRIVE_FIRST..LAW_FIRST].copy_from_slice(&drive_of(model, self.volts.is_some()));
        at[LAW_FIRST..MACHINE].copy_from_slice(&law_of(model, &self.knots));
        let [ratio, difference] =
            ["ratio", "asymmetry"].map(|name| plain("slip_ratio", name).clamp(-0.9, 0.9));
        let [right, left] =
            [0.5, -0.5].map(|side| (1.0 - ratio - side * difference).max(0.05).ln());
        let scale = f64::midpoint(right, left);
        at[ASYMMETRY] += right - left;
        for (i, run) in self.runs.iter().enumerate() {
            let first = self.of_run(i, RUN);
            let guesses = run.noise_guesses(2.0 * self.half_track_m);
            at[first..first + RUN_NOISE].copy_from_slice(&guesses);
            at[self.of_run(i, RUN_SCALE)] = match self.as_before(i) {
                Some(_) => 0.0,
                None => scale,
            };
            for (parameter, offset) in self.offsets.get(i).into_iter().flatten().enumerate() {
                at[self.of_run(i, parameter)] += offset;
            }
        }
        if self.before.any() {
            let shared = self.shared(0);
            let (changes, rest) = at.split_at_mut(shared);
            rest[..MACHINE].copy_from_slice(&changes[..MACHINE]);
            changes[..MACHINE].fill(0.0);
        }
        at
    }

    /// The run from before on whose course a run of today is, and whose floor and clocks it shares.
    pub(crate) fn as_before(&self, run: usize) -> Option<usize> {
        run.checked_sub(self.before.runs)
            .filter(|_| self.before.is_paired())
    }

    /// The parameters of one run, out of all.
    pub(crate) fn local(&self, run: usize, at: &[f64]) -> Vec<f64> {
        let first = self.of_run(run, 0);
        let mut own = if self.before.any() {
            comparison::of_machine(at, MACHINE, self.shared(0), self.before.has(run))
        } else {
            at[..MACHINE].to_vec()
        };
        own.extend(&at[first..first + RUN + RUN_NOISE]);
        if let Some(other) = self.as_before(run) {
            for parameter in RUN_SHARED {
                own[MACHINE + parameter] += at[self.of_run(other, parameter)];
            }
        }
        own
    }

    /// Where the parameters of a run stand among all: pairs of the run's own number and the index.
    pub(crate) fn places(&self, run: usize) -> Vec<(usize, usize)> {
        let first = self.of_run(run, 0);
        let mut places = if self.before.any() {
            comparison::places(MACHINE, self.shared(0), self.before.has(run))
        } else {
            (0..MACHINE).map(|i| (i, i)).collect()
        };
        places.extend((0..RUN + RUN_NOISE).map(|i| (MACHINE + i, first + i)));
        if let Some(other) = self.as_before(run) {
            places.extend(RUN_SHARED.map(|own| (MACHINE + own, self.of_run(other, own))));
        }
        places
    }

    pub(crate) fn pose_filter<'a>(
        &self,
        run: &'a Run,
        series: &'a [Vec<PoseRow>],
        robust: bool,
    ) -> WheelsToPose<'a> {
        WheelsToPose {
            series,
            wheel_radius_m: self.wheel_radius_m,
            half_track_m: self.half_track_m,
            declared_m: run.declared_m,
            wheel_interval_s: run.wheel_interval_s,
            first_heading_rad: run.first_heading_rad,
            knots: self.knots,
            robust,
        }
    }

    pub(crate) fn gyro_filter<'a>(
        &self,
        series: &'a [Vec<(f64, f64)>],
        robust: bool,
    ) -> gyro_filter::Gyro<'a> {
        gyro_filter::Gyro {
            series,
            wheel_radius_m: self.wheel_radius_m,
            half_track_m: self.half_track_m,
            knots: self.knots[0],
            robust,
        }
    }

    /// The same machine with poses as dense as they are; `None` where they are too many.
    pub(crate) fn dense(&self) -> Option<Self> {
        let mut dense = self.clone();
        for run in &mut dense.runs {
            if let Some(pose) = &run.pose {
                run.pose = Some(pose.dense()?);
            }
        }
        Some(dense)
    }

    /// Where a run went, filtered: time (s), x, y (m) and heading (rad) of the centre of mass.
    pub(crate) fn course(&self, run: usize, at: &[f64]) -> Vec<(f64, [f64; 3])> {
        let own = &self.runs[run];
        let Some(pose) = &own.pose else {
            return Vec::new();
        };
        let local = self.local(run, at);
        let series = [pose.all.clone()];
        let filter = self.pose_filter(own, &series, true);
        let mut points = Vec::new();
        own.wheels.turned(drive_parameters(&local), |wheels| {
            let mut seen = |stamp_s: f64, [x, y, heading]: [f64; 3]| {
                let late_s = local[POSE_LATENCY] + local[MACHINE + RUN_POSE_LATE];
                let t_s = (stamp_s - late_s) / (1.0 + local[POSE_RATE]);
                let (sin, cos) = heading.sin_cos();
                let ahead = self.com_to_axle_m;
                points.push((
                    t_s + own.origin_s,
                    [x + ahead * cos, y + ahead * sin, heading],
                ));
            };
            filter.follow(wheels, &pose_parameters(&local), &mut |_| (), &mut seen);
        });
        points
    }

    /// Heading at the first pose where the reference has none: dead reckoning over the first part of
    /// the way turned onto the positions (Procrustes).
    fn first_heading(&self, run: &Run) -> f64 {
        let Some(pose) = &run.pose else { return 0.0 };
        let mut hint = 0;
        let mut at = [0.0_f64; 3];
        let mut last: Option<[f64; 2]> = None;
        let mut way = 0.0;
        let mut points = Vec::new();
        let rows = &pose.all;
        let angles: Vec<[f64; 2]> = run.wheels.turned(&[0.0; DRIVE], |wheels| {
            let all = rows
                .iter()
                .map(|(t_s, _)| wheels.angles_at(*t_s, &mut hint));
            all.collect()
        });
        for ((_, z), angles) in rows.iter().zip(angles) {
            let turned = last.map_or([0.0; 2], |last| [angles[0] - last[0], angles[1] - last[1]]);
            last = Some(angles);
            let ds = (turned[0] + turned[1]) * self.wheel_radius_m / 2.0;
            let turn = (turned[0] - turned[1]) * self.wheel_radius_m / (2.0 * self.half_track_m);
            let (sin, cos) = (at[2] + turn / 2.0).sin_cos();
            at = [at[0] + ds * cos, at[1] + ds * sin, at[2] + turn];
            way += ds.abs();
            points.push(([at[0], at[1]], [z[0], z[1]], way));
        }
        let enough = (6.0 * self.half_track_m).max(0.1 * way).min(0.5 * way);
        let used: Vec<_> = points.iter().take_while(|p| p.2 <= enough).collect();
        type Pair = ([f64; 2], [f64; 2], f64);
        let mean = |which: fn(&Pair) -> [f64; 2]| {
            let sum = used
                .iter()
                .fold([0.0; 2], |s, p| [s[0] + which(p)[0], s[1] + which(p)[1]]);
            sum.map(|s| s / used.len().max(1) as f64)
        };
        let [u, q] = [mean(|p| p.0), mean(|p| p.1)];
        let (mut dot, mut cross) = (0.0, 0.0);
        for (a, b, _) in used.iter().copied() {
            let [a, b] = [[a[0] - u[0], a[1] - u[1]], [b[0] - q[0], b[1] - q[1]]];
            dot += a[0] * b[0] + a[1] * b[1];
            cross += a[0] * b[1] - a[1] * b[0];
        }
        f64::atan2(cross, dot)
    }
}

/// What the wheels are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reference {
    Pose = 0,
    Gyro = 1,
}

impl Reference {
    pub(crate) const ALL: [Self; 2] = [Self::Pose, Self::Gyro];
}

/// Keeps of two runs the rows of their references that both have; `false` where these are too few.
/// `stamped` is how much later and faster than the wheels these were stamped.
fn match_runs(
    [first, second]: [&mut Run; 2],
    robots: &[&Robot],
    stamped: &mut [[f64; 2]; SHARES],
) -> bool {
    let both = [robots[first.robot], robots[second.robot]];
    let wheels = if first.wheels.is_commanded() {
        Stamps::new(both, |own| own.command.as_ref())
    } else {
        Stamps::new(both, |own| own.wheels.as_ref())
    };
    let poses = Stamps::new(both, |own| own.pose.as_ref());
    let rates = Stamps::new(both, |own| own.imu.as_ref());
    *stamped = [&poses, &rates].map(|own| shift_against(own.as_ref(), wheels.as_ref()));
    let interval_s = first.wheel_interval_s;
    let poses = match (&mut first.pose, &mut second.pose) {
        (Some(a), Some(b)) => poses.is_some_and(|stamps| match_poses(&stamps, [a, b])),
        (a, b) => a.is_none() && b.is_none(),
    };
    let rates = match (&mut first.gyro, &mut second.gyro) {
        (Some(a), Some(b)) => rates.is_some_and(|stamps| match_rates(&stamps, [a, b], interval_s)),
        (a, b) => a.is_none() && b.is_none(),
    };
    poses && rates
}

/// Values of the laws that a model lists, as parameters at these knots.
fn law_of(model: &RobotModel, knots: &[Knots; 2]) -> Vec<f64> {
    let each = TABLES.iter().flat_map(|own| {
        let zero = vec![0.0; own.count];
        nominal::laws(model, own).fold(zero, |sum, table| {
            let own = knots[own.over].parameters(own.count, &table);
            sum.iter().zip(own).map(|(a, b)| a + b).collect()
        })
    });
    each.collect()
}

/// Whether a recording says that the robot steers by skidding.
fn skids(robot: &Robot) -> bool {
    let drive = robot.notes.get("drive").and_then(|value| value.as_str());
    drive.is_some_and(|drive| drive.to_lowercase().contains("skid"))
}
