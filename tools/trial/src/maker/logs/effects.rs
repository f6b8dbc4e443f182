//! The effects that a case can conceal: in which logs they show, and how large they are.
//!
//! Their sizes are those that a careful person could see in the log.

use super::log::{Log, LogEffect, Source, Value, quantile};
use super::robot::PoseKind;
use crate::maker::manoeuvre::rounded;
use crate::maker::random::RandomStream;

/// An effect that can be drawn.
struct Offer {
    id: &'static str,
    /// At most one effect of a group: what a log cannot tell apart when both act.
    group: &'static [&'static str],
    shows: fn(&Log) -> bool,
    /// Puts it into the robot; `None` where this drive would not show it.
    draw: fn(&mut Log, &mut RandomStream) -> Option<LogEffect>,
}

/// Clocks and delays: of three, two relations show.
const CLOCKS: &[&str] = &[
    "pose_latency",
    "wheels_latency",
    "imu_latency",
    "actuator_delay",
];
/// Factors between command, wheels and floor: of three, two relations show.
const SCALES: &[&str] = &[
    "wheel_radius",
    "slip_ratio",
    "encoder_scale",
    "motor_gain",
    "supply_sag",
];
/// Duration from which on a clock is off by enough (s).
const DRIFT_S: f64 = 50.0;
/// What cuts the command.
const SHAPES: &[&str] = &[
    "command_dead_zone",
    "command_dead_band",
    "command_saturation",
];

/// One row an effect.
const OFFERS: [Offer; 16] = [
    Offer {
        id: "wheel_radius",
        group: SCALES,
        shows: has_poses,
        draw: wheel_radius,
    },
    Offer {
        id: "track_width",
        group: &["track_width"],
        shows: |_| true,
        draw: track_width,
    },
    Offer {
        id: "slip_ratio",
        group: SCALES,
        shows: has_poses,
        draw: slip_ratio,
    },
    Offer {
        id: "pose_offset",
        group: &["pose_offset"],
        shows: Log::sees_drives,
        draw: pose_offset,
    },
    Offer {
        id: "pose_latency",
        group: CLOCKS,
        shows: Log::sees_drives,
        draw: |log, random| late(log, Source::Pose, random),
    },
    Offer {
        id: "wheels_latency",
        group: CLOCKS,
        shows: told_beside_reference,
        draw: |log, random| late(log, Source::Wheels, random),
    },
    Offer {
        id: "imu_latency",
        group: CLOCKS,
        shows: |log| log.streams.gyro,
        draw: |log, random| late(log, Source::Gyro, random),
    },
    Offer {
        id: "encoder_scale",
        group: SCALES,
        shows: told_and_wheels,
        draw: encoder_scale,
    },
    Offer {
        id: "actuator_delay",
        group: CLOCKS,
        shows: told,
        draw: actuator_delay,
    },
    Offer {
        id: "actuator_lag",
        group: &["actuator_lag"],
        shows: told,
        draw: actuator_lag,
    },
    Offer {
        id: "motor_gain",
        group: SCALES,
        shows: told,
        draw: motor_gain,
    },
    Offer {
        id: "command_dead_zone",
        group: SHAPES,
        shows: told,
        draw: dead_zone,
    },
    Offer {
        id: "command_dead_band",
        group: SHAPES,
        shows: told,
        draw: dead_band,
    },
    Offer {
        id: "command_saturation",
        group: SHAPES,
        shows: told,
        draw: |log, random| saturation(log, [0.55, 0.8], random),
    },
    Offer {
        id: "clock_drift",
        group: &["clock_drift"],
        shows: |log| log.runs.len() == 1 && log.duration_s() > DRIFT_S,
        draw: clock_drift,
    },
    Offer {
        id: "supply_sag",
        group: SCALES,
        shows: |log| told(log) && log.runs.len() == 1,
        draw: supply_sag,
    },
];

fn told(log: &Log) -> bool {
    log.has(Source::Command)
}

fn told_and_wheels(log: &Log) -> bool {
    told(log) && log.has(Source::Wheels)
}

/// Whether a reference tells late wheels from a late drive.
fn told_beside_reference(log: &Log) -> bool {
    told_and_wheels(log) && (log.sees_drives() || log.streams.gyro)
}

fn has_poses(log: &Log) -> bool {
    log.has(Source::Pose)
}

/// Conceals up to `count` effects beside those that nuisances brought.
pub(super) fn conceal(log: &mut Log, count: usize, random: &mut RandomStream) {
    let mut left = count;
    // A case in which hardly anything shows takes what there is.
    for _ in 0..100 {
        let offer = random.choose(&OFFERS);
        if left == 0 {
            break;
        }
        if !(offer.shows)(log) || log.conceals(offer.group) || log.conceals(&[offer.id]) {
            continue;
        }
        if let Some(effect) = (offer.draw)(log, random) {
            log.effects.push(effect);
            left -= 1;
        }
    }
}

/// Effects that a log with these streams cannot tell from this one.
pub(super) fn look_alikes(id: &str, log: &Log) -> Vec<&'static str> {
    let (told, wheels) = (log.has(Source::Command), log.has(Source::Wheels));
    let poses = log.has(Source::Pose);
    match id {
        "wheel_radius" | "slip_ratio" if !wheels => {
            vec!["wheel_radius", "slip_ratio", "motor_gain"]
        }
        "wheel_radius" | "slip_ratio" if !told => {
            vec!["wheel_radius", "slip_ratio", "encoder_scale"]
        }
        "wheel_radius" | "slip_ratio" => vec!["wheel_radius", "slip_ratio"],
        "motor_gain" if !wheels => vec!["wheel_radius", "slip_ratio"],
        "track_width" if !poses => vec!["wheel_radius", "encoder_scale"],
        "actuator_delay" if wheels && !told_beside_reference(log) => vec!["wheels_latency"],
        "actuator_delay" if !wheels => vec!["pose_latency", "imu_latency"],
        "pose_latency" | "imu_latency" if !wheels => vec!["actuator_delay"],
        "pose_latency" | "imu_latency" if !told => vec!["wheels_latency"],
        _ => Vec::new(),
    }
    .into_iter()
    .filter(|other| *other != id)
    .collect()
}

/// How far a parameter may be off whatever its interval: what recordings of one machine differ by without anybody
/// calling it a change.
pub(super) fn tolerance(effect: &LogEffect, name: &str, log: &Log) -> Option<f64> {
    let frame_s = |source: Source| 0.1 * log.streams.periods_s[source as usize];
    let usual = match (effect.id, name) {
        ("wheel_radius" | "encoder_scale" | "motor_gain", _) => 0.006,
        ("track_width", _) => 0.008,
        ("slip_ratio", _) => 0.01,
        ("pose_offset", "yaw_rad") => 0.005,
        ("pose_offset", _) => 0.04 * log.robot.half_track_m,
        ("pose_latency", _) => f64::max(0.005, frame_s(Source::Pose)),
        ("wheels_latency", _) => f64::max(0.005, frame_s(Source::Wheels)),
        ("imu_latency", _) => f64::max(0.005, frame_s(Source::Gyro)),
        ("actuator_delay" | "actuator_lag", _) => 0.005,
        ("clock_drift", "rate") => 2e-4,
        ("supply_sag", _) => 0.01 / log.duration_s(),
        (_, "speed_rad_s") => 0.02 * log.robot.speed_m_s / log.robot.wheel_radius_m,
        _ => return None,
    };
    Some(usual + effect.tolerance)
}

/// Names of the scales of both wheels.
const SCALE_NAMES: [&str; 2] = ["right_scale", "left_scale"];

fn scales(common: f64, random: &mut RandomStream) -> [f64; 2] {
    let apart = random.sign() * random.log_uniform(0.002, 0.015);
    [1.0 + common + apart, 1.0 + common - apart].map(rounded)
}

/// Wheels that are alike too large or too small, and apart.
fn drawn_scales(random: &mut RandomStream) -> [f64; 2] {
    let common = random.sign() * random.log_uniform(0.02, 0.1);
    scales(common, random)
}

/// An effect of both wheels: `names` are those of the right and of the left one.
fn of_wheels(id: &'static str, names: [&'static str; 2], values: [f64; 2]) -> Option<LogEffect> {
    let parameters = [0, 1].map(|i| (names[i], values[i]));
    Some(LogEffect::new(id, &parameters))
}

fn wheel_radius(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    let scales = drawn_scales(random);
    log.plant.radius_scale = scales;
    of_wheels("wheel_radius", SCALE_NAMES, scales)
}

fn track_width(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    let scale = rounded(1.0 + random.sign() * random.log_uniform(0.03, 0.15));
    log.plant.track_scale = scale;
    Some(LogEffect::new("track_width", &[("scale", scale)]))
}

fn slip_ratio(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    let ratio = rounded(random.log_uniform(0.04, 0.35));
    log.runs
        .iter_mut()
        .for_each(|run| run.floor.slip_ratio = ratio);
    Some(LogEffect::new("slip_ratio", &[("ratio", ratio)]))
}

fn pose_offset(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    let least_m = 3.0 * log.sensors.noise[0];
    let distance_m = f64::max(
        2.0 * log.robot.half_track_m * random.log_uniform(0.1, 0.8),
        least_m,
    );
    let direction = random.uniform(-3.1, 3.1);
    let [x, y] = [distance_m * direction.cos(), distance_m * direction.sin()].map(rounded);
    let turn = rounded(random.sign() * random.log_uniform(0.03, 0.2));
    let mut parameters = vec![("x_m", x), ("y_m", y)];
    if log.streams.pose == Some(PoseKind::Full) {
        log.sensors.pose_offset = [x, y, turn];
        parameters.push(("yaw_rad", turn));
    } else {
        log.sensors.pose_offset = [x, y, 0.0];
    }
    Some(LogEffect::new("pose_offset", &parameters))
}

/// Stamps of a source are late.
pub(super) fn late(log: &mut Log, source: Source, random: &mut RandomStream) -> Option<LogEffect> {
    let latency_s = rounded(random.log_uniform(0.04, 0.3));
    log.sensors.latency_s[source as usize] = latency_s;
    Some(LogEffect::new(
        source.latency()?,
        &[("latency_s", latency_s)],
    ))
}

fn encoder_scale(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    let scales = drawn_scales(random);
    log.sensors.encoder_scale = scales;
    of_wheels("encoder_scale", SCALE_NAMES, scales)
}

fn actuator_delay(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    log.plant.delay_s = rounded(random.log_uniform(0.04, 0.3));
    Some(LogEffect::new(
        "actuator_delay",
        &[("delay_s", log.plant.delay_s)],
    ))
}

fn actuator_lag(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    log.plant.lag_s = rounded(random.log_uniform(0.08, 0.5));
    Some(LogEffect::new(
        "actuator_lag",
        &[("time_constant_s", log.plant.lag_s)],
    ))
}

fn motor_gain(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    let common = if random.bernoulli(0.7) {
        -random.log_uniform(0.03, 0.15)
    } else {
        random.log_uniform(0.03, 0.08)
    };
    let gains = scales(common, random);
    log.plant.gain = gains;
    of_wheels("motor_gain", ["right", "left"], gains)
}

fn dead_zone(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    let usual = quantile(&log.told_rad_s(), 0.8);
    let size = rounded(usual * random.uniform(0.05, 0.15));
    log.plant.dead_zone_rad_s = size;
    Some(LogEffect::new(
        "command_dead_zone",
        &[("speed_rad_s", size)],
    ))
}

/// A dead band as wide as 6 to 15 % of what is told lies in it; none where the robot would hardly move.
fn dead_band(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    let told = log.told_rad_s();
    let size = rounded(quantile(&told, random.uniform(0.06, 0.15)));
    if size > 0.5 * quantile(&told, 0.5) || size < 0.03 * quantile(&told, 0.9) {
        return None;
    }
    log.plant.dead_band_rad_s = size;
    Some(LogEffect::new(
        "command_dead_band",
        &[("speed_rad_s", size)],
    ))
}

/// A saturation at a share of the speeds that are told.
pub(super) fn saturation(
    log: &mut Log,
    [low, high]: [f64; 2],
    random: &mut RandomStream,
) -> Option<LogEffect> {
    let size = rounded(quantile(&log.told_rad_s(), 0.95) * random.uniform(low, high));
    log.plant.saturation_rad_s = size;
    (size > 0.0).then(|| LogEffect::new("command_saturation", &[("speed_rad_s", size)]))
}

/// One clock is off by 50 to 150 ms at the end of a minute or more.
fn clock_drift(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    let can = |source: &Source| match source {
        Source::Command => false,
        Source::Wheels => told_beside_reference(log),
        Source::Pose => log.sees_drives(),
        Source::Gyro => log.streams.gyro,
    };
    let sources: Vec<Source> = Source::ALL.into_iter().filter(can).collect();
    if sources.is_empty() {
        return None;
    }
    let source = *random.choose(&sources);
    let rate = rounded(random.sign() * random.log_uniform(0.05, 0.15) / log.duration_s());
    log.sensors.drift[source as usize] += rate;
    let mut effect = LogEffect::new("clock_drift", &[("rate", rate)]);
    effect
        .parameters
        .push(("stream", Value::Text(source.name())));
    Some(effect)
}

fn supply_sag(log: &mut Log, random: &mut RandomStream) -> Option<LogEffect> {
    let rate = rounded(random.uniform(0.08, 0.3) / log.duration_s());
    log.plant.sag_per_s = rate;
    Some(LogEffect::new("supply_sag", &[("rate_per_s", rate)]))
}
