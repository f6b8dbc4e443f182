//! The catalogue of effects: complete, and the only effects that a model may list.

use std::collections::BTreeSet;

use slipstream_bus::RobotModel;
use slipstream_sim::Robot;
use slipstream_sim::effects::{CATALOGUE, Domain};

/// The catalogue has every effect of the vocabulary that other programs know, no effect twice, and for
/// each an equation, channels, and probes inside its bounds.
#[test]
fn the_catalogue_is_complete() {
    let vocabulary = "wheel_slip friction_patch rolling_resistance viscous_drag quadratic_drag \
        caster_drag yaw_scrub axle_friction torque_speed_droop actuator_lag actuator_delay \
        motor_gain supply_sag command_dead_band command_saturation backlash load_transfer \
        wheel_radius track_width payload floor_slope pose_offset pose_latency wheels_latency \
        imu_latency encoder_scale clock_drift link_delay push";
    let known: BTreeSet<&str> = CATALOGUE.iter().map(|info| info.id).collect();
    assert_eq!(known.len(), CATALOGUE.len());
    let missing: Vec<&str> = vocabulary
        .split_whitespace()
        .filter(|id| !known.contains(id))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
    for info in CATALOGUE {
        assert!(
            !info.channels.is_empty() && !info.equation.is_empty(),
            "{}",
            info.id
        );
        for parameter in info.parameters {
            if let Domain::Number {
                lower,
                upper,
                probes,
            } = parameter.domain
            {
                assert!(
                    probes.iter().all(|p| (lower..=upper).contains(p)),
                    "{}",
                    info.id
                );
            }
        }
    }
}

/// Invalid effects are rejected, naming the key.
#[test]
fn rejects_invalid_effects_naming_the_key() {
    type Case = (&'static str, &'static [(&'static str, f64)], &'static str);
    let cases: [Case; 7] = [
        ("wheel_slipp", &[], "effects.wheel_slipp"),
        (
            "viscous_drag",
            &[("coeficient", 1.0)],
            "effects.viscous_drag.coeficient",
        ),
        (
            "viscous_drag",
            &[("coefficient", f64::NAN)],
            "effects.viscous_drag.coefficient",
        ),
        (
            "viscous_drag",
            &[("coefficient", -1.0)],
            "effects.viscous_drag.coefficient",
        ),
        (
            "wheel_slip",
            &[("friction_static", 0.2)],
            "effects.wheel_slip.friction_kinetic",
        ),
        ("command_dead_band", &[], "effects.command_dead_band"),
        (
            "payload",
            &[("mass_kg", 9.0), ("x_m", 0.5), ("y_m", 0.0)],
            "effects.payload.x_m",
        ),
    ];
    for (effect, parameters, key) in cases {
        let error = Robot::new(&RobotModel::default().with(effect, parameters)).unwrap_err();
        assert_eq!(error.place, key, "{error}");
    }
    let mut kinematic = RobotModel::default().with("viscous_drag", &[("coefficient", 1.0)]);
    kinematic.robot.body_mass_kg = None;
    assert_eq!(
        Robot::new(&kinematic).unwrap_err().place,
        "robot.body_mass_kg"
    );
}
