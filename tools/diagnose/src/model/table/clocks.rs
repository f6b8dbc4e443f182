//! Which streams are late, and whose clock runs fast.

use super::draft::Place::{Drive, Reference};
use super::draft::{Draft, Drafted, Place, Row, Shown, about};
use super::known::Known;
use super::sizes::{
    LATENCIES_S, LATENCY_INFLATION, LEAST_DRIFT_S, RATE, RATE_COST, RATE_INFLATION, STAMP_SHARE,
    TIME_S, WHEELS_COST, repeatability,
};
use crate::estimate::term::Link;
use crate::model::drive::{CLOCK, DELAY};
use crate::model::run::Run;
use crate::model::wheel_parameters::{
    GYRO_LATENCY, GYRO_RATE, POSE_LATENCY, POSE_RATE, RUN_POSE_LATE,
};

impl Known<'_> {
    /// Which streams are late, and whose clock runs fast.
    pub(super) fn clocks(&self, all: &mut Vec<Draft>) {
        let pose_s = STAMP_SHARE * self.longest_s(Run::pose_interval_s);
        let gyro_s = STAMP_SHARE * self.longest_s(|run| run.wheel_interval_s);
        let reference = self.streams.reference;
        let both = self.has_pose && self.has_gyro;
        let has_wheels = !self.is_commanded && self.has_reference();
        // wheels and one reference are all: nothing tells which of both is late
        let two = self.streams.drive.is_none() && !both;
        let repeatable = |interval_s: f64| repeatability::TIME_S.max(interval_s);
        let late = |name, moves: Vec<(Place, f64)>, resolution: f64| Row {
            name,
            number: 0,
            moves,
            prior: about(0.3),
            resolution,
            repeatability: repeatable(resolution),
        };
        let stamped = reference.before.stamped;
        let mut add_late = |row: Row, effect, mirror, stamped_s: f64| {
            let mut shown = Shown::plain(effect, "latency_s");
            if two {
                shown.mirror = mirror;
                shown.confused = mirror.iter().map(|(other, _)| *other).collect();
            }
            let starts = LATENCIES_S.map(|own| vec![own]).into_iter();
            let starts = starts.chain((stamped_s != 0.0).then(|| vec![stamped_s]));
            let mut draft = Draft::new(row.name, vec![row], vec![shown]).from(starts);
            draft.inflation = LATENCY_INFLATION;
            if effect == "wheels_latency" {
                draft.cost = WHEELS_COST;
            }
            all.push(draft);
        };
        let wheels = Some(("wheels_latency", -1.0));
        let is_of_runs = self.asked.by_run[2];
        if self.has_pose && !self.is_commanded && !is_of_runs {
            let row = late("late pose", vec![(Reference(POSE_LATENCY), 1.0)], pose_s);
            add_late(row, "pose_latency", wheels, stamped[0][0]);
        }
        if self.tells_clock() && (self.has_pose || !self.is_commanded) {
            let row = late("late gyro", vec![(Reference(GYRO_LATENCY), 1.0)], gyro_s);
            let mirror = wheels.filter(|_| !self.is_commanded);
            add_late(row, "imu_latency", mirror, stamped[1][0]);
        }
        if has_wheels && !two {
            let moves = self.of_wheels([POSE_LATENCY, GYRO_LATENCY], DELAY);
            let row = late("late wheels", moves, TIME_S.max(gyro_s));
            add_late(row, "wheels_latency", None, -stamped[0][0]);
        }
        if is_of_runs {
            self.late_poses(all, two);
        }
        self.rates(all, has_wheels && !two, [pose_s, gyro_s]);
    }

    /// Whether the gyro tells its clock: it hears turns alone.
    fn tells_clock(&self) -> bool {
        self.has_gyro && self.streams.reference.turns()
    }

    /// Whose clock runs fast; `tells`: what else there is tells the clock of the wheels. What stamps of poses and gyro mean
    /// within their intervals is a convention of so many seconds.
    fn rates(&self, all: &mut Vec<Draft>, tells: bool, [pose_s, gyro_s]: [f64; 2]) {
        let duration_s = self.duration_s();
        let fast = |name, moves: Vec<(Place, f64)>, stamp_s: f64| Row {
            name,
            number: 0,
            moves,
            prior: about(0.003),
            resolution: RATE.max(stamp_s / duration_s),
            repeatability: repeatability::RATE,
        };
        let mut add_fast = |row: Row, stream: &'static str| {
            let mut shown = Shown::plain("clock_drift", "rate");
            shown.word = Some(("stream", stream));
            let mut draft = Draft::new(row.name, vec![row], vec![shown]);
            draft.inflation = RATE_INFLATION;
            draft.cost = RATE_COST;
            draft.later = true;
            all.push(draft);
        };
        if self.has_pose {
            add_fast(
                fast("fast pose", vec![(Reference(POSE_RATE), 1.0)], pose_s),
                "pose",
            );
        }
        if self.tells_clock() && !self.streams.reference.has_clocks_of_runs() {
            add_fast(
                fast("fast gyro", vec![(Reference(GYRO_RATE), 1.0)], gyro_s),
                "imu",
            );
        }
        // by its commands alone, a drive that speeds up otherwise than it slows down looks like a drift while that is short
        let is_told = self.has_reference() || self.duration_s() > LEAST_DRIFT_S;
        if tells || self.streams.drive.is_some() && is_told {
            let moves = self.of_wheels([POSE_RATE, GYRO_RATE], CLOCK);
            add_fast(fast("fast wheels", moves, 0.0), "wheels");
        }
    }

    /// Poses of each run are stamped late by themselves; `two`: nothing tells which of wheels and poses is late.
    fn late_poses(&self, all: &mut Vec<Draft>, two: bool) {
        let runs: Vec<usize> = (0..self.streams.reference.runs.len()).collect();
        let shown = runs.iter().enumerate().map(|(place, run)| {
            let values = vec![("latency_s", Link::Identity, vec![(place, 1.0)])];
            let mut shown = Shown::new("pose_latency", values);
            shown.run = Some(*run);
            if self.is_commanded {
                shown.confused = vec!["actuator_delay"];
            } else if two {
                shown.mirror = Some(("wheels_latency", -1.0));
                shown.confused = vec!["wheels_latency"];
            }
            shown
        });
        let mut draft = Draft::new("latency of runs", Vec::new(), shown.collect());
        draft.rows = runs
            .iter()
            .map(|run| Drafted::Run {
                name: "run pose late",
                run: *run,
                place: RUN_POSE_LATE,
                deviation: 0.3,
            })
            .collect();
        draft.inflation = LATENCY_INFLATION;
        all.push(draft);
    }

    /// What the clock of the wheels moves.
    pub(super) fn of_wheels(&self, references: [usize; 2], drive: usize) -> Vec<(Place, f64)> {
        let has = [self.has_pose, self.has_gyro];
        let own = references.into_iter().zip(has).filter(|(_, has)| *has);
        let own = own.map(|(index, _)| (Reference(index), -1.0));
        own.chain(self.streams.drive.map(|_| (Drive(drive), 1.0)))
            .collect()
    }
}
