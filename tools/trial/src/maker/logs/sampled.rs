//! Rows of a drive as its sensors measure them.

use std::f64::consts::TAU;

use super::log::{Log, Source, purpose};
use super::plant::{State, Trace};
use super::robot::{PoseKind, WheelKind};
use super::rows::{Quantity, Row, Rows};
use crate::maker::manoeuvre::rounded;
use crate::maker::random::RandomStream;

/// When the sensors measure: at their period, from a random instant on, until the drive ends.
fn instants(log: &Log, source: Source, run: usize, random: &mut RandomStream) -> Vec<f64> {
    let period_s = log.streams.periods_s[source as usize];
    let first_s = random.unit() * period_s;
    let count = ((log.runs[run].duration_s - first_s) / period_s).floor();
    (0..count as usize)
        .map(|k| first_s + k as f64 * period_s)
        .collect()
}

/// The rows of a source in one run, stamped with its latency; `None` where it is not logged.
pub(super) fn rows(log: &Log, source: Source, run: usize, trace: &Trace) -> Option<Rows> {
    if !log.has(source) {
        return None;
    }
    let mut random =
        RandomStream::new(log.seed, purpose::SENSORS + 10 * run as u64 + source as u64);
    let period_s = log.streams.periods_s[source as usize];
    let latency_s =
        log.sensors.latency_s[source as usize] + log.runs[run].latency_s[source as usize];
    let row = |true_s: f64, behind_s: f64, values: [f64; 3]| Row {
        t_s: true_s + latency_s,
        true_s: true_s - behind_s,
        values,
    };
    let (quantity, rows) = match source {
        Source::Command => {
            let told = log.commands(run).into_iter().enumerate();
            let rows =
                told.map(|(k, [one, other])| row(k as f64 * period_s, 0.0, [one, other, 0.0]));
            (Quantity::Command, rows.collect())
        }
        Source::Wheels => {
            let kind = log.streams.wheels?;
            let phase = [random.unit(), random.unit()];
            let wheels = Counters { log, phase };
            let times = instants(log, source, run, &mut random).into_iter();
            let behind_s = if kind == WheelKind::MeanSpeeds {
                period_s / 2.0
            } else {
                0.0
            };
            let rows = times.map(|t_s| row(t_s, behind_s, wheels.read(kind, trace, t_s, period_s)));
            (wheels.quantity(kind), rows.collect())
        }
        Source::Pose => {
            let kind = log.streams.pose?;
            let times = instants(log, source, run, &mut random).into_iter();
            let all: Vec<Row> = times
                .map(|t_s| row(t_s, 0.0, pose(log, &trace.at(t_s), &mut random)))
                .collect();
            let rows = match (kind, all.as_slice()) {
                (PoseKind::Sparse, [first, .., last]) => vec![*first, *last],
                _ => all,
            };
            (Quantity::Pose, rows)
        }
        Source::Gyro => {
            let times = instants(log, source, run, &mut random).into_iter();
            let half_s = period_s / 2.0;
            let mean = |t_s: f64| {
                let [from, to] = [t_s - half_s, t_s + half_s].map(|t_s| trace.at(t_s).pose[2]);
                (to - from) / period_s
            };
            let rows = times.map(|t_s| {
                let turn_rad_s = if log.streams.momentary_gyro {
                    trace.at(t_s).turn_rad_s
                } else {
                    mean(t_s)
                };
                let noise = random.normal(log.sensors.noise[2]);
                row(t_s, 0.0, [turn_rad_s + noise, 0.0, 0.0])
            });
            (Quantity::Gyro, rows.collect())
        }
    };
    Some(Rows {
        quantity,
        period_s,
        rows,
    })
}

/// What the reference measures.
fn pose(log: &Log, state: &State, random: &mut RandomStream) -> [f64; 3] {
    let [x, y, yaw] = state.pose;
    let [forward, left, turn] = log.sensors.pose_offset;
    let (sin, cos) = yaw.sin_cos();
    let [noise_m, noise_rad, _] = log.sensors.noise;
    [
        x + forward * cos - left * sin + random.normal(noise_m),
        y + forward * sin + left * cos + random.normal(noise_m),
        yaw + turn + random.normal(noise_rad),
    ]
}

/// The counters of both wheels.
struct Counters<'a> {
    log: &'a Log,
    /// Where each is between two counts at the start.
    phase: [f64; 2],
}

impl Counters<'_> {
    fn quantity(&self, kind: WheelKind) -> Quantity {
        match kind {
            WheelKind::Ticks => Quantity::Counts,
            WheelKind::Angles => Quantity::Angles,
            WheelKind::MeanSpeeds | WheelKind::Speeds => Quantity::Speeds,
        }
    }

    /// What is logged at a time, in columns.
    fn read(&self, kind: WheelKind, trace: &Trace, t_s: f64, period_s: f64) -> [f64; 3] {
        let step_rad = TAU / self.log.streams.counts;
        let now = self.counts(trace, t_s);
        let [right, left] = match kind {
            WheelKind::Ticks => now,
            WheelKind::Angles => now.map(|count| count * step_rad),
            WheelKind::MeanSpeeds => {
                let before = self.counts(trace, t_s - period_s);
                [0, 1].map(|i| (now[i] - before[i]) * step_rad / period_s)
            }
            WheelKind::Speeds => [0, 1]
                .map(|i| rounded(trace.at(t_s).speed_rad_s[i] * self.log.sensors.encoder_scale[i])),
        };
        [right, left, 0.0]
    }

    fn counts(&self, trace: &Trace, t_s: f64) -> [f64; 2] {
        let turns = trace.at(t_s).angle_rad.map(|angle| angle / TAU);
        let scale = self.log.sensors.encoder_scale;
        [0, 1].map(|i| (turns[i] * scale[i] * self.log.streams.counts + self.phase[i]).floor())
    }
}
