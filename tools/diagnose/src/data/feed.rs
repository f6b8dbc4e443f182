//! The streams of a robot as they come, a segment at a time: what filters read of the last seconds.
//!
//! Rows are made by the same readings as those of whole recordings. What is older than the filters need is let go.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{Robot, Wheels as Recorded};
use slipstream_sim::Command;

use super::command::{CommandPath, asked, per_unit};
use super::reference::PoseRow;
use super::streams::{self, WheelKind};
use super::wheel_path::WheelPath;
use super::wheels::{GAP, wheel_speeds};

/// How long wheels are kept (s), and commands, whose lags last longer.
const WHEELS_S: f64 = 12.0;
const COMMANDS_S: f64 = 20.0;
/// Rows of a stream that wait for the wheels at most.
const MOST_WAITING: usize = 4096;
/// Counts at which counters of encoders begin again.
const WRAPS: [i64; 2] = [1 << 16, 1 << 32];
/// A step that is this much smaller with a wrap than without is one.
const WRAP_SHARE: f64 = 0.125;
/// Least time (s) after which a log of changes says that the wheels stand.
const STANDS_S: f64 = 0.5;

/// What a stream's rows did that they should not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Oddity {
    /// A stamp (s) came behind a later one.
    Backwards { stream: &'static str, t_s: f64 },
    /// Stamps jumped by so much (s).
    Jumped {
        stream: &'static str,
        t_s: f64,
        by_s: f64,
    },
    /// A counter began again.
    Wrapped { t_s: f64 },
}

/// What a baseline says of the streams.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Habits {
    /// Wheels are logged when they change alone, so often (s).
    pub(crate) changes_every_s: Option<f64>,
    /// How long a drive remembers its commands (s).
    pub(crate) remembers_s: f64,
    /// Forces are heard: commands of any kind are kept as they were told.
    pub(crate) of_forces: bool,
}

/// Streams as they come.
#[derive(Debug, Clone)]
pub(crate) struct Feed {
    pub(crate) habits: Habits,
    /// What times count from (s): the first stamp.
    pub(crate) origin_s: Option<f64>,
    /// The last stamp of any stream (s).
    pub(crate) now_s: f64,
    pub(crate) wheels: WheelPath,
    /// Rows of the wheels for the drive: angles (rad) or speeds (rad/s).
    pub(crate) rows: VecDeque<(f64, [f64; 2])>,
    pub(crate) kind: WheelKind,
    pub(crate) rounding_rad: f64,
    pub(crate) commands: CommandPath,
    /// Where forces are heard, commands.
    pub(crate) told: Vec<(f64, Command)>,
    pub(crate) poses: VecDeque<PoseRow>,
    /// The integrated gyro: stamp (s), angle (rad).
    pub(crate) rates: VecDeque<(f64, f64)>,
    rate: Option<(f64, f64)>,
    angle: f64,
    speeds: Option<(f64, [f64; 2])>,
    counts: Option<[i64; 2]>,
    wrapped: [i64; 2],
    told_s: f64,
    /// The last pose (s).
    seen_s: Option<f64>,
    heading: Option<(f64, f64)>,
}

impl Feed {
    pub(crate) fn new(habits: Habits) -> Self {
        Self {
            habits,
            origin_s: None,
            now_s: f64::NEG_INFINITY,
            wheels: WheelPath::default(),
            rows: VecDeque::new(),
            kind: WheelKind::Angle,
            rounding_rad: 0.0,
            commands: CommandPath::default(),
            told: Vec::new(),
            poses: VecDeque::new(),
            rates: VecDeque::new(),
            rate: None,
            angle: 0.0,
            speeds: None,
            counts: None,
            wrapped: [0; 2],
            told_s: f64::NEG_INFINITY,
            seen_s: None,
            heading: None,
        }
    }

    /// Takes the rows of a segment; returns what was odd about them.
    pub(crate) fn take(&mut self, robot: &Robot, model: &RobotModel) -> Vec<Oddity> {
        let mut odd = Vec::new();
        let Some(origin_s) = self.origin_s.or_else(|| first_stamp(robot)) else {
            return odd;
        };
        self.origin_s = Some(origin_s);
        self.take_commands(robot, model, origin_s);
        self.take_wheels(robot, model, origin_s, &mut odd);
        self.take_poses(robot, origin_s, &mut odd);
        self.take_gyro(robot, origin_s, &mut odd);
        self.rest();
        self.forget();
        odd
    }

    fn take_commands(&mut self, robot: &Robot, model: &RobotModel, origin_s: f64) {
        let (r, b) = (model.robot.wheel_radius_m, model.robot.half_track_m);
        for (stamp_s, command) in streams::commands(robot) {
            let t_s = stamp_s - origin_s;
            if self.habits.of_forces && t_s > self.told_s && is_finite(&command) {
                self.told.push((t_s, command));
            }
            let per_unit = per_unit(&command, model);
            if per_unit.is_some() || self.habits.of_forces {
                self.now_s = self.now_s.max(t_s);
            }
            if t_s <= self.told_s {
                continue;
            }
            self.told_s = t_s;
            let Some(per_unit) = per_unit else { continue };
            let speeds = asked(&command, r, b).map(|own| own * per_unit);
            let path = &mut self.commands;
            if speeds.iter().all(|own| own.is_finite()) && path.speeds_rad_s.last() != Some(&speeds)
            {
                path.times_s.push(t_s);
                path.speeds_rad_s.push(speeds);
            }
        }
    }

    fn take_wheels(
        &mut self,
        robot: &Robot,
        model: &RobotModel,
        origin_s: f64,
        odd: &mut Vec<Oddity>,
    ) {
        let counts = robot.counts_per_rev(Some(model));
        let unwrapped = self.unwrapped(robot, origin_s, odd);
        let robot = unwrapped.as_ref().unwrap_or(robot);
        let rows = if robot.wheels.is_some() {
            let Some(own) = streams::wheels(robot, model) else {
                return;
            };
            self.kind = own.kind;
            self.rounding_rad = own.rounding_rad.unwrap_or(0.0);
            own.rows
        } else {
            self.kind = WheelKind::Speed;
            wheel_speeds(robot, model).unwrap_or_default()
        };
        let most_rad = counts.map_or(f64::INFINITY, |own| TAU * 1e9 / own.max(1e-9));
        for (stamp_s, value) in rows {
            let t_s = stamp_s - origin_s;
            let last_s = self.wheels.times_s.last().copied();
            if !self.follows("wheels", last_s, t_s, odd) || value.iter().any(|v| v.abs() > most_rad)
            {
                continue;
            }
            let angles = match self.kind {
                WheelKind::Angle => value,
                WheelKind::Speed => self.integrated(t_s, value),
            };
            self.stood(t_s);
            self.wheels.times_s.push(t_s);
            self.wheels.angles_rad.push(angles);
            self.rows.push_back((t_s, value));
        }
    }

    /// Angles behind speeds, by the trapezoidal rule.
    fn integrated(&mut self, t_s: f64, speeds: [f64; 2]) -> [f64; 2] {
        let last = self.wheels.angles_rad.last().copied().unwrap_or([0.0; 2]);
        match self.speeds.replace((t_s, speeds)) {
            Some((last_s, before)) => {
                [0, 1].map(|i| last[i] + (t_s - last_s) * (speeds[i] + before[i]) / 2.0)
            }
            None => last,
        }
    }

    /// In a log of changes wheels stood until shortly before a row that ends a gap.
    fn stood(&mut self, t_s: f64) {
        let (Some(every_s), Some(last_s)) =
            (self.habits.changes_every_s, self.wheels.times_s.last())
        else {
            return;
        };
        if t_s - last_s > GAP * every_s
            && let Some(angles) = self.wheels.angles_rad.last().copied()
        {
            self.wheels.times_s.push(t_s - every_s);
            self.wheels.angles_rad.push(angles);
        }
    }

    /// In a log of changes wheels that say nothing stand.
    fn rest(&mut self) {
        let (Some(every_s), Some(last_s)) =
            (self.habits.changes_every_s, self.wheels.times_s.last())
        else {
            return;
        };
        let until_s = self.now_s - (GAP * every_s).max(STANDS_S);
        if until_s > *last_s
            && let Some(angles) = self.wheels.angles_rad.last().copied()
        {
            self.wheels.times_s.push(until_s);
            self.wheels.angles_rad.push(angles);
        }
    }

    fn take_poses(&mut self, robot: &Robot, origin_s: f64, odd: &mut Vec<Oddity>) {
        for (stamp_s, [x, y, yaw]) in streams::poses(robot).unwrap_or_default() {
            let t_s = stamp_s - origin_s;
            if x.is_finite() && y.is_finite() {
                let last_s = self.seen_s;
                if self.follows("poses", last_s, t_s, odd) {
                    self.seen_s = Some(t_s);
                    self.poses.push_back((t_s, [x, y, yaw]));
                }
            } else if robot.imu.is_none() {
                // headings alone are a gyro
                if let Some((last_s, last)) = self.heading.replace((t_s, yaw))
                    && t_s > last_s
                {
                    let turned = yaw - last - TAU * ((yaw - last) / TAU).round();
                    self.angle += turned;
                    self.now_s = self.now_s.max(t_s);
                    self.rates.push_back((t_s, self.angle));
                }
            }
        }
    }

    fn take_gyro(&mut self, robot: &Robot, origin_s: f64, odd: &mut Vec<Oddity>) {
        for (stamp_s, [.., rate]) in streams::inertial(robot).unwrap_or_default() {
            let t_s = stamp_s - origin_s;
            let last_s = self.rate.map(|own| own.0);
            if !rate.is_finite() || !self.follows("the inertial sensor", last_s, t_s, odd) {
                continue;
            }
            if let Some((last_s, last)) = self.rate.replace((t_s, rate)) {
                self.angle += (t_s - last_s) * (rate + last) / 2.0;
            }
            self.rates.push_back((t_s, self.angle));
        }
    }

    /// Whether a stamp comes after the last one of its stream.
    fn follows(
        &mut self,
        stream: &'static str,
        last_s: Option<f64>,
        t_s: f64,
        odd: &mut Vec<Oddity>,
    ) -> bool {
        let Some(last_s) = last_s else {
            self.now_s = self.now_s.max(t_s);
            return t_s.is_finite();
        };
        if t_s <= last_s {
            if t_s < last_s {
                odd.push(Oddity::Backwards { stream, t_s });
            }
            return false;
        }
        if t_s - last_s > JUMP_S {
            let by_s = t_s - last_s;
            odd.push(Oddity::Jumped { stream, t_s, by_s });
        }
        self.now_s = self.now_s.max(t_s);
        true
    }

    /// The same robot with counters that run on; `None` where none began again.
    fn unwrapped(&mut self, robot: &Robot, origin_s: f64, odd: &mut Vec<Oddity>) -> Option<Robot> {
        let stream = robot.wheels.as_ref()?;
        let Recorded::Ticks { right, left } = &stream.values else {
            return None;
        };
        let mut all = [right.clone(), left.clone()];
        for row in 0..stream.t_s.len() {
            let (Some(a), Some(b)) = (all[0][row], all[1][row]) else {
                continue;
            };
            let counts = [a, b];
            for (wheel, own) in all.iter_mut().enumerate() {
                let before = self.counts.map_or(counts[wheel], |own| own[wheel]);
                if let Some(wrap) = wrap(before, counts[wheel]) {
                    self.wrapped[wheel] = self.wrapped[wheel].wrapping_sub(wrap);
                    let t_s = stream.t_s[row] - origin_s;
                    odd.push(Oddity::Wrapped { t_s });
                }
                own[row] = Some(counts[wheel].wrapping_add(self.wrapped[wheel]));
            }
            self.counts = Some(counts);
        }
        if self.wrapped == [0; 2] {
            return None;
        }
        let [right, left] = all;
        let mut own = robot.clone();
        own.wheels.as_mut()?.values = Recorded::Ticks { right, left };
        Some(own)
    }

    /// Lets go of what is older than filters need.
    fn forget(&mut self) {
        let path = &mut self.wheels;
        let old = path
            .times_s
            .partition_point(|t_s| *t_s < self.now_s - WHEELS_S);
        if old > path.times_s.len() / 2 {
            path.times_s.drain(..old);
            path.angles_rad.drain(..old);
        }
        let path = &mut self.commands;
        let old = path
            .times_s
            .partition_point(|t_s| *t_s < self.now_s - self.habits.remembers_s.max(COMMANDS_S));
        if old > 1 {
            // the last one of them still holds
            path.times_s.drain(..old - 1);
            path.speeds_rad_s.drain(..old - 1);
            path.running = true;
        }
        let waiting = [
            self.rows.len(),
            self.poses.len(),
            self.rates.len(),
            self.told.len(),
        ];
        if waiting.iter().any(|own| *own > MOST_WAITING) {
            self.drop_waiting();
        }
    }

    /// Lets go of rows that nobody hears.
    pub(crate) fn drop_all(&mut self) {
        self.rows.clear();
        self.poses.clear();
        self.rates.clear();
    }

    /// Of rows that wait for what does not come, the older half goes.
    fn drop_waiting(&mut self) {
        let half = |len: usize| len.saturating_sub(MOST_WAITING / 2);
        self.rows.drain(..half(self.rows.len()));
        self.poses.drain(..half(self.poses.len()));
        self.rates.drain(..half(self.rates.len()));
        self.told.drain(..half(self.told.len()));
    }
}

/// Stamps of one stream that are this far apart jumped (s).
const JUMP_S: f64 = 60.0;

/// By how much a counter that went from one count to another began again: both within its range, near its ends.
fn wrap(from: i64, to: i64) -> Option<i64> {
    let change = to.wrapping_sub(from);
    let within = |own: i64, lowest: i64| {
        (lowest..lowest + own).contains(&from) && (lowest..lowest + own).contains(&to)
    };
    let size = |change: i64| change.unsigned_abs() as f64;
    let mut all = WRAPS.into_iter();
    let own = all.find(|own| {
        (within(*own, 0) || within(*own, -own / 2))
            && size(change) > *own as f64 / 2.0
            && size(change.wrapping_sub(own * change.signum())) < WRAP_SHARE * size(change)
    });
    own.map(|own| own * change.signum())
}

/// Whether a command is a number.
fn is_finite(command: &Command) -> bool {
    asked(command, 1.0, 1.0).iter().all(|own| own.is_finite())
}

/// The first stamp of any stream (s).
fn first_stamp(robot: &Robot) -> Option<f64> {
    let firsts = robot.stamps().filter_map(|own| own.first().copied());
    firsts.filter(|t_s| t_s.is_finite()).min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use slipstream_recording::recording::Stream;

    use super::*;

    fn robot(t_s: Vec<f64>, right: Vec<i64>) -> Robot {
        let mut robot = Robot::named("r1");
        robot.encoder_counts_per_rev = Some(100.0);
        robot.wheels = Some(Stream {
            t_s,
            values: Recorded::Ticks {
                left: right.iter().map(|own| Some(own / 2)).collect(),
                right: right.into_iter().map(Some).collect(),
            },
            unknown: vec![],
        });
        robot
    }

    #[test]
    fn a_counter_that_begins_again_runs_on() {
        let mut feed = Feed::new(Habits::default());
        let model = RobotModel::default();
        assert!(
            feed.take(&robot(vec![5.0], vec![65_530]), &model)
                .is_empty()
        );
        let odd = feed.take(&robot(vec![5.1, 5.2], vec![4, 14]), &model);
        assert_eq!(odd.len(), 1);
        let tick = TAU / 100.0;
        let turned: Vec<f64> = feed.wheels.angles_rad.iter().map(|own| own[0]).collect();
        for (own, counts) in turned.iter().zip([65_530.0, 65_540.0, 65_550.0]) {
            assert!((own - counts * tick).abs() < 1e-9);
        }
    }

    #[test]
    fn rows_out_of_order_are_left_out_and_said() {
        let mut feed = Feed::new(Habits::default());
        let odd = feed.take(
            &robot(vec![1.0, 1.2, 1.1, 1.3], vec![0, 2, 1, 3]),
            &RobotModel::default(),
        );
        let stream = "wheels";
        assert!(matches!(odd[..], [Oddity::Backwards { stream: own, .. }] if own == stream));
        assert_eq!(feed.wheels.times_s.len(), 3);
    }

    #[test]
    fn memory_does_not_grow() {
        let mut feed = Feed::new(Habits::default());
        let model = RobotModel::default();
        for k in 0..5000 {
            let t_s = f64::from(k) * 0.5;
            feed.take(
                &robot(
                    vec![t_s, t_s + 0.25],
                    vec![10 * i64::from(k), 10 * i64::from(k) + 5],
                ),
                &model,
            );
        }
        assert!(feed.wheels.times_s.len() < 200 && feed.rows.len() <= MOST_WAITING);
    }
}
