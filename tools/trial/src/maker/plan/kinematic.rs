//! Robots without known masses, under commanded speeds: every effect in every set of streams that shows it,
//! pairs, and nulls, each without and with process noise that grows with speed.

use super::case_spec::{CaseSpec, Streams};
use crate::maker::manoeuvre::{CommandKind, Style};
use crate::maker::process_noise::NoiseKind;
use crate::maker::scene::{Camera, Control};

const fn streams(wheels: bool, camera: Camera, gyro: bool) -> Streams {
    Streams {
        wheels,
        camera,
        gyro,
    }
}

/// Sets of streams, with the effects that show in them.
const SETS: [(Streams, &[&str]); 5] = [
    (
        streams(true, Camera::Pose, false),
        &[
            "wheel_radius",
            "track_width",
            "encoder_scale",
            "motor_gain",
            "actuator_delay",
            "actuator_lag",
            "command_dead_band",
            "command_saturation",
            "supply_sag",
            "pose_offset",
            "pose_latency",
            "wheels_latency",
            "clock_drift",
        ],
    ),
    (
        streams(false, Camera::Pose, false),
        &[
            "wheel_radius",
            "track_width",
            "motor_gain",
            "actuator_delay",
            "actuator_lag",
            "command_dead_band",
            "command_saturation",
            "supply_sag",
            "pose_offset",
            "pose_latency",
            "clock_drift",
        ],
    ),
    (
        streams(false, Camera::Absent, true),
        &[
            "wheel_radius",
            "track_width",
            "motor_gain",
            "actuator_delay",
            "actuator_lag",
            "command_dead_band",
            "command_saturation",
            "supply_sag",
            "imu_latency",
            "clock_drift",
        ],
    ),
    // The heading's part of a pose offset does not show without the heading.
    (
        streams(true, Camera::Position, false),
        &[
            "wheel_radius",
            "track_width",
            "encoder_scale",
            "motor_gain",
            "actuator_delay",
            "actuator_lag",
            "command_dead_band",
            "command_saturation",
            "supply_sag",
            "pose_latency",
            "wheels_latency",
            "clock_drift",
        ],
    ),
    (streams(true, Camera::Pose, true), &["imu_latency"]),
];

/// Pairs that show with encoders and camera.
const PAIRS: [[&str; 2]; 6] = [
    ["wheel_radius", "actuator_delay"],
    ["track_width", "pose_offset"],
    ["encoder_scale", "pose_latency"],
    ["motor_gain", "actuator_lag"],
    ["command_dead_band", "track_width"],
    ["supply_sag", "wheels_latency"],
];

/// All cases of robots without known masses.
pub(super) fn kinematic() -> Vec<CaseSpec> {
    let mut specs = Vec::new();
    for (streams, effects) in SETS {
        for (at, id) in effects.iter().enumerate() {
            specs.extend(both("single", &[id], streams, at));
        }
    }
    for (at, pair) in PAIRS.iter().enumerate() {
        specs.extend(both("pair", pair, SETS[0].0, at));
    }
    for (streams, _) in SETS {
        for at in 0..2 {
            specs.extend(both("null", &[], streams, at));
        }
    }
    specs
}

/// A case without and with process noise; the kind of command alternates with `at`.
fn both(kind: &str, effects: &[&'static str], streams: Streams, at: usize) -> [CaseSpec; 2] {
    [false, true].map(|noisy| {
        let kind = format!(
            "{kind}, {}{}",
            name(streams),
            if noisy { ", noise" } else { "" }
        );
        let command_kind = [CommandKind::Twist, CommandKind::WheelSpeed][at % 2];
        CaseSpec {
            noise: noisy.then_some((NoiseKind::Speed, [0.2, 0.5, 0.8][at % 3])),
            streams: Some(streams),
            command_kind: Some(command_kind),
            control: Some(Control::Open),
            style: Some(Style::Lively),
            ..CaseSpec::new(&kind, effects)
        }
    })
}

/// The streams in words.
fn name(streams: Streams) -> &'static str {
    match (streams.wheels, streams.camera, streams.gyro) {
        (true, Camera::Pose, false) => "wheels and camera",
        (true, Camera::Position, _) => "camera without heading",
        (true, ..) => "wheels, camera and gyro",
        (false, Camera::Absent, _) => "gyro",
        (false, ..) => "camera",
    }
}
