//! Recordings that start inside what acts: in a friction patch, sliding, moving, pressing against a dead band.

use super::case_spec::{Begin, CaseSpec};
use crate::maker::manoeuvre::CommandKind;
use crate::maker::scene::Control;

/// Effects of a robot that is already moving.
const OF_MOTION: [&str; 8] = [
    "rolling_resistance",
    "viscous_drag",
    "yaw_scrub",
    "motor_gain",
    "actuator_delay",
    "wheel_radius",
    "pose_offset",
    "pose_latency",
];
/// Sizes, one after the other.
const SIZES: [f64; 3] = [0.4, 0.6, 0.8];

/// All cases with such a start.
pub(super) fn starts() -> Vec<CaseSpec> {
    let open = |at: usize, start: Begin, kind: &str, effects: &[&'static str]| CaseSpec {
        start,
        size: Some(SIZES[at % SIZES.len()]),
        control: Some(Control::Open),
        command_kind: Some([CommandKind::Torque, CommandKind::Voltage][at % 2]),
        ..CaseSpec::new(kind, effects)
    };
    let mut specs = Vec::new();
    for at in 0..6 {
        let control = [Control::Open, Control::Closed][at / 2 % 2];
        let kind = [CommandKind::Torque, CommandKind::Voltage][at % 2];
        specs.push(CaseSpec {
            // Both wheels stand in the patch.
            size: Some(0.75 + 0.05 * at as f64),
            control: Some(control),
            command_kind: Some(if control == Control::Open {
                kind
            } else {
                CommandKind::Torque
            }),
            ..open(at, Begin::InPatch, "start in a patch", &["friction_patch"])
        });
        specs.push(open(at, Begin::Sliding, "start sliding", &["wheel_slip"]));
    }
    for (at, id) in OF_MOTION.iter().enumerate() {
        specs.push(open(at, Begin::Moving, "start moving", &[id]));
    }
    for command_kind in [
        CommandKind::Torque,
        CommandKind::Voltage,
        CommandKind::Twist,
        CommandKind::WheelSpeed,
    ] {
        for at in 0..2 {
            specs.push(CaseSpec {
                command_kind: Some(command_kind),
                ..open(at, Begin::Moving, "null, start moving", &[])
            });
        }
    }
    for (at, command_kind) in [CommandKind::Torque, CommandKind::WheelSpeed]
        .into_iter()
        .cycle()
        .take(6)
        .enumerate()
    {
        let effects = &["command_dead_band"];
        specs.push(CaseSpec {
            command_kind: Some(command_kind),
            ..open(at, Begin::Pressing, "start at a dead band", effects)
        });
    }
    specs
}
