//! What real logs have, and what real robots do, whatever is concealed: one row a nuisance.

use super::log::{DrawnNuisance, Log, LogEffect, Source, purpose};
use super::robot::{PoseKind, WheelKind};
use super::rows::Rows;
use super::stamps::within;
use super::wander::{Wander, WanderKind};
use super::{counters, effects, references, stamps};
use crate::maker::manoeuvre::rounded;
use crate::maker::random::RandomStream;

/// A nuisance.
pub(super) struct Nuisance {
    pub(super) name: &'static str,
    /// In how many cases that can have it.
    probability: f64,
    pub(super) apply: Apply,
}

/// How a nuisance is applied, by its size from 0 to 1. Each says whether there was something to apply it to.
#[derive(Clone, Copy)]
pub(super) enum Apply {
    /// To the robot and its log, when the case is drawn.
    Case(fn(&mut Log, f64, &mut RandomStream) -> bool),
    /// To rows of these streams, when the case is made.
    Rows(
        &'static [Source],
        fn(&mut Rows, f64, &mut RandomStream) -> bool,
    ),
}

use Apply::{Case, Rows as OnRows};

const ALL: &[Source] = &Source::ALL;
const SENSORS: &[Source] = &[Source::Wheels, Source::Pose, Source::Gyro];
const WHEELS: &[Source] = &[Source::Wheels];
const POSE: &[Source] = &[Source::Pose];
const GYRO: &[Source] = &[Source::Gyro];

const fn row(name: &'static str, probability: f64, apply: Apply) -> Nuisance {
    Nuisance {
        name,
        probability,
        apply,
    }
}

/// All nuisances, in the order in which they are applied. Those that are effects of the vocabulary go into the label.
pub(super) const TABLE: [Nuisance; 31] = [
    // what is logged
    row("fractional_counts", 0.15, Case(fractional_counts)),
    row("mean_speeds", 0.12, Case(mean_speeds)),
    row("momentary_speeds", 0.08, Case(momentary_speeds)),
    row("momentary_gyro", 0.30, Case(momentary_gyro)),
    row("no_heading", 0.12, Case(no_heading)),
    row("sparse_poses", 0.15, Case(sparse_poses)),
    // what the robot does
    row("skid_track", 0.15, Case(skid_track)),
    row("turn_loss", 0.10, Case(turn_loss)),
    row("slow_drive", 0.15, Case(slow_drive)),
    row("saturating_drive", 0.12, Case(saturating_drive)),
    row("floor_by_run", 0.30, Case(floor_by_run)),
    row(
        "steady_noise",
        0.25,
        Case(|log, size, random| wander(log, WanderKind::Steady, size, random)),
    ),
    row(
        "noise_with_speed",
        0.15,
        Case(|log, size, random| wander(log, WanderKind::Speed, size, random)),
    ),
    row(
        "gusts",
        0.15,
        Case(|log, size, random| wander(log, WanderKind::Gusts, size, random)),
    ),
    // clocks
    row("late_gyro", 0.20, Case(late_gyro)),
    row("latency_by_run", 0.20, Case(latency_by_run)),
    row("second_clock", 0.30, Case(second_clock)),
    row("other_epoch", 0.40, Case(other_epoch)),
    // values
    row(
        "accumulating_reference",
        0.20,
        OnRows(POSE, references::accumulate),
    ),
    row("jumping_reference", 0.08, OnRows(POSE, references::jumps)),
    row("outliers", 0.12, OnRows(POSE, references::outliers)),
    row("gyro_bias", 0.40, OnRows(GYRO, references::bias)),
    row("reset_counter", 0.08, OnRows(WHEELS, counters::reset)),
    row("wrapped_counter", 0.20, OnRows(WHEELS, counters::wrap)),
    row("glitch", 0.08, OnRows(WHEELS, counters::glitch)),
    // rows and stamps
    row("dropped_rows", 0.25, OnRows(ALL, stamps::dropped)),
    row("held_rows", 0.12, OnRows(SENSORS, stamps::held)),
    row("saw_tooth_lag", 0.15, OnRows(SENSORS, stamps::saw_tooth)),
    row("bursts", 0.12, OnRows(SENSORS, stamps::bursts)),
    row("jitter", 0.40, OnRows(ALL, stamps::jitter)),
    row("doubled_rows", 0.12, OnRows(ALL, stamps::doubled)),
];

/// Factors of all probabilities, one of which a case draws: some logs are clean, some rough.
const ROUGHNESS: [f64; 8] = [0.0, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0, 1.5];

/// Draws the nuisances of a case, and applies those that act on the robot and its log as a whole.
pub(super) fn draw(log: &mut Log) {
    let roughness = *RandomStream::new(log.seed, purpose::NUISANCES).choose(&ROUGHNESS);
    for (at, nuisance) in TABLE.iter().enumerate() {
        let mut random = RandomStream::new(log.seed, purpose::NUISANCES + 1 + at as u64);
        let (is_drawn, size) = (
            random.bernoulli(roughness * nuisance.probability),
            random.unit(),
        );
        if !is_drawn {
            continue;
        }
        let on = match nuisance.apply {
            Case(apply) => {
                if !apply(log, size, &mut random) {
                    continue;
                }
                Vec::new()
            }
            OnRows(sources, _) => streams(log, sources, &mut random),
        };
        log.nuisances.push(DrawnNuisance { row: at, size, on });
    }
}

/// The streams that have a nuisance of rows: half of those that can.
fn streams(log: &Log, sources: &[Source], random: &mut RandomStream) -> Vec<Source> {
    let mut can = sources.to_vec();
    // Two poses a run are no stream of rows.
    can.retain(|source| log.has(*source) && (*source != Source::Pose || log.sees_drives()));
    let mut on = can.clone();
    on.retain(|_| random.bernoulli(0.5));
    if on.is_empty() && !can.is_empty() {
        on.push(*random.choose(&can));
    }
    on
}

/// Counts per turn that are no whole number; such wheels are logged as angles.
fn fractional_counts(log: &mut Log, _: f64, random: &mut RandomStream) -> bool {
    log.streams.counts += rounded(random.uniform(0.1, 0.9));
    replace_wheels(log, WheelKind::Angles)
}

fn mean_speeds(log: &mut Log, _: f64, _: &mut RandomStream) -> bool {
    replace_wheels(log, WheelKind::MeanSpeeds)
}

fn momentary_speeds(log: &mut Log, _: f64, _: &mut RandomStream) -> bool {
    replace_wheels(log, WheelKind::Speeds)
}

/// A gyro that is read at the instant of a row, without a filter before.
fn momentary_gyro(log: &mut Log, _: f64, _: &mut RandomStream) -> bool {
    log.streams.momentary_gyro = true;
    log.streams.gyro
}

/// Logs the wheels in another form than counters.
fn replace_wheels(log: &mut Log, kind: WheelKind) -> bool {
    let are_ticks = log.streams.wheels == Some(WheelKind::Ticks);
    if are_ticks {
        log.streams.wheels = Some(kind);
    }
    are_ticks
}

/// The reference sees positions alone; where there are no wheels, it has to see the heading.
fn no_heading(log: &mut Log, _: f64, _: &mut RandomStream) -> bool {
    let can = log.has(Source::Pose) && log.has(Source::Wheels);
    if can {
        log.streams.pose = Some(PoseKind::Position);
    }
    can
}

/// One pose before and one after each of at least three drives.
fn sparse_poses(log: &mut Log, _: f64, _: &mut RandomStream) -> bool {
    let can =
        log.has(Source::Wheels) && log.streams.pose == Some(PoseKind::Full) && log.runs.len() > 2;
    if can {
        log.streams.pose = Some(PoseKind::Sparse);
    }
    can
}

/// An effective track of 1.2 to 2 times, up to 6 % larger to one side and up to 25 % smaller in the gentlest curves.
fn skid_track(log: &mut Log, size: f64, random: &mut RandomStream) -> bool {
    log.plant.skid = Some(super::plant::Skid {
        scale: within([1.2, 2.0], size),
        aside: random.uniform(-0.06, 0.06),
        gentle: random.uniform(0.0, 0.25),
    });
    log.allowed.push("unknown");
    // Its parameters are those that come of the drives: see `label`.
    log.effects.push(LogEffect::new("track_width", &[]));
    true
}

/// In the sharpest curve a robot loses 3 to 12 % of its speed.
fn turn_loss(log: &mut Log, size: f64, _: &mut RandomStream) -> bool {
    let shows = log.sees_drives();
    if shows {
        log.plant.turn_loss_m =
            within([0.03, 0.12], size) * log.robot.speed_m_s / log.robot.turn_rad_s;
        log.allowed.push("unknown");
    }
    shows
}

/// 5 to 30 % of what is told come through an integral action with a time constant of 0.5 to 3 s.
fn slow_drive(log: &mut Log, size: f64, random: &mut RandomStream) -> bool {
    let shows = log.has(Source::Command);
    if shows {
        log.plant.slow = [within([0.05, 0.3], size), random.log_uniform(0.5, 3.0)];
        log.allowed.extend(["actuator_lag", "unknown"]);
    }
    shows
}

/// Wheels that cannot turn as fast as they are told at the most.
fn saturating_drive(log: &mut Log, _: f64, random: &mut RandomStream) -> bool {
    let shows = log.has(Source::Command);
    let effect = shows
        .then(|| effects::saturation(log, [0.75, 0.92], random))
        .flatten();
    log.effects.extend(effect);
    shows
}

/// Floors that differ: hard at first, then with slip; for a robot that skids, other tracks.
fn floor_by_run(log: &mut Log, size: f64, random: &mut RandomStream) -> bool {
    if log.runs.len() < 2 || !log.has(Source::Pose) && log.plant.skid.is_none() {
        return false;
    }
    for run in 1..log.runs.len() {
        if log.plant.skid.is_some() {
            log.runs[run].floor.track = rounded(random.uniform(0.85, 1.15));
        } else {
            let ratio = rounded(within([0.04, 0.3], size) * random.uniform(0.6, 1.3));
            log.runs[run].floor.slip_ratio = ratio;
            let slip = LogEffect::new("slip_ratio", &[("ratio", ratio)]);
            log.effects.push(slip.in_run(run));
        }
    }
    true
}

/// Noise of the contact: 0.3 to 3 % of the largest speed and turn rate; gusts are ten times as large.
fn wander(log: &mut Log, kind: WanderKind, size: f64, random: &mut RandomStream) -> bool {
    let rare = if kind == WanderKind::Gusts { 10.0 } else { 1.0 };
    let share = rare * within([0.003, 0.03], size);
    log.plant.noise.push(Wander {
        kind,
        size: [
            share * log.robot.speed_m_s,
            share * log.robot.turn_rad_s * random.uniform(0.5, 1.5),
        ],
        time_s: random.log_uniform(0.05, 1.0),
        between_s: random.log_uniform(4.0, 20.0),
    });
    true
}

/// A gyro whose stamps are late.
fn late_gyro(log: &mut Log, _: f64, random: &mut RandomStream) -> bool {
    let effect = log
        .streams
        .gyro
        .then(|| effects::late(log, Source::Gyro, random))
        .flatten();
    let is_late = effect.is_some();
    log.effects.extend(effect);
    is_late
}

/// The reference is late by another time in every run.
fn latency_by_run(log: &mut Log, _: f64, random: &mut RandomStream) -> bool {
    let source = if log.sees_drives() {
        Source::Pose
    } else {
        Source::Gyro
    };
    let can = log.has(source)
        && log.runs.len() > 1
        && log.effects.iter().all(|own| own.id != "imu_latency");
    let Some(id) = source.latency().filter(|_| can) else {
        return false;
    };
    for run in 0..log.runs.len() {
        let latency_s = rounded(random.uniform(0.02, 0.3));
        log.runs[run].latency_s[source as usize] = latency_s;
        let late = LogEffect::new(id, &[("latency_s", latency_s)]);
        log.effects.push(late.in_run(run));
    }
    true
}

/// The reference has a clock of its own, off by 5 to 50 ppm: less than anybody would call a drift.
fn second_clock(log: &mut Log, size: f64, random: &mut RandomStream) -> bool {
    let rate = random.sign() * within([5e-6, 5e-5], size);
    let can = log.has(Source::Pose) || log.streams.gyro;
    for source in [Source::Pose, Source::Gyro] {
        log.sensors.drift[source as usize] += rate;
    }
    can
}

/// Time counts from a boot or from 1970.
fn other_epoch(log: &mut Log, size: f64, random: &mut RandomStream) -> bool {
    let epoch_s = if size < 0.4 {
        random.uniform(20.0, 90_000.0)
    } else {
        random.uniform(1.3e9, 1.8e9)
    };
    log.epoch_s = rounded(epoch_s);
    true
}
