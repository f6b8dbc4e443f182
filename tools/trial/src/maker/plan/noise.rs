//! Process noise: nulls without and with each kind of it, effects that stand out of it, and pairs.

use super::case_spec::CaseSpec;
use crate::maker::manoeuvre::{CommandKind, Style};
use crate::maker::process_noise::NoiseKind;
use crate::maker::scene::Control;

/// Kinds of command, open and closed loop.
const SETUPS: [(CommandKind, Control); 6] = [
    (CommandKind::Torque, Control::Open),
    (CommandKind::Voltage, Control::Open),
    (CommandKind::WheelSpeed, Control::Open),
    (CommandKind::Twist, Control::Open),
    (CommandKind::Torque, Control::Closed),
    (CommandKind::Torque, Control::Platoon),
];
/// Styles of driving, one after the other.
const STYLES: [Style; 3] = [Style::Lively, Style::Cruise, Style::Lively];
/// Sizes of the noise, one after the other.
const SIZES: [f64; 3] = [0.15, 0.5, 0.85];
/// Effects that are looked for under each kind of noise.
const SINGLES: [&str; 15] = [
    "wheel_slip",
    "rolling_resistance",
    "viscous_drag",
    "yaw_scrub",
    "axle_friction",
    "motor_gain",
    "actuator_delay",
    "actuator_lag",
    "supply_sag",
    "wheel_radius",
    "track_width",
    "encoder_scale",
    "payload",
    "floor_slope",
    "pose_offset",
];
/// Pairs, two for each kind of noise.
const PAIRS: [[&str; 2]; 8] = [
    ["rolling_resistance", "track_width"],
    ["motor_gain", "pose_offset"],
    ["viscous_drag", "wheel_radius"],
    ["floor_slope", "encoder_scale"],
    ["payload", "actuator_delay"],
    ["yaw_scrub", "pose_latency"],
    ["supply_sag", "track_width"],
    ["wheel_slip", "pose_offset"],
];

/// All cases with process noise, and as many nulls without.
pub(super) fn noise() -> Vec<CaseSpec> {
    [nulls(), singles(), pairs()].concat()
}

fn nulls() -> Vec<CaseSpec> {
    let mut specs = Vec::new();
    for (setup, (command_kind, control)) in SETUPS.into_iter().enumerate() {
        for at in 0..6 {
            let null = |kind: &str, noise: Option<(NoiseKind, f64)>| CaseSpec {
                noise,
                command_kind: Some(command_kind),
                control: Some(control),
                style: Some(STYLES[at % STYLES.len()]),
                ..CaseSpec::new(kind, &[])
            };
            specs.push(null("null", None));
            let kind = NoiseKind::ALL[(at + setup) % NoiseKind::ALL.len()];
            let size = SIZES[(at + setup) % SIZES.len()];
            specs.push(null(&format!("null, {}", kind.name()), Some((kind, size))));
        }
    }
    specs
}

fn singles() -> Vec<CaseSpec> {
    let all = NoiseKind::ALL.into_iter().enumerate();
    let each = all.flat_map(|(k, kind)| {
        let size = move |at: usize| SIZES[(at + k) % SIZES.len()];
        SINGLES.iter().enumerate().map(move |(at, id)| CaseSpec {
            noise: Some((kind, size(at))),
            ..CaseSpec::new(&format!("single, {}", kind.name()), &[id])
        })
    });
    each.collect()
}

fn pairs() -> Vec<CaseSpec> {
    let pair = |(at, pair): (usize, &[&'static str; 2])| {
        let kind = NoiseKind::ALL[at % NoiseKind::ALL.len()];
        CaseSpec {
            noise: Some((kind, SIZES[at % SIZES.len()])),
            ..CaseSpec::new(&format!("pair, {}", kind.name()), pair)
        }
    };
    PAIRS.iter().enumerate().map(pair).collect()
}
