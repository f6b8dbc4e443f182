//! The catalogue of effects: complete, and the only effects that a model may list.

use std::collections::BTreeSet;

use slipstream_bus::{EffectSpec, Parameter, RobotModel};
use slipstream_sim::effects::{CATALOGUE, Domain};
use slipstream_sim::{CommandKind, Robot};

/// The catalogue has every effect of the vocabulary that other programs know, no effect twice, and for
/// each a summary, an equation and its source, channels, parameters, and probes inside their bounds.
#[test]
fn the_catalogue_is_complete() {
    let vocabulary = "wheel_slip friction_patch rolling_resistance viscous_drag quadratic_drag \
        caster_drag yaw_scrub axle_friction torque_speed_droop actuator_lag actuator_delay \
        motor_gain supply_sag command_dead_band command_saturation backlash load_transfer \
        wheel_radius slip_ratio track_width payload floor_slope command_dead_zone force_law \
        motion_law pose_offset pose_latency wheels_latency \
        imu_latency encoder_scale clock_drift link_delay push";
    let known: BTreeSet<&str> = CATALOGUE.iter().map(|info| info.id).collect();
    assert_eq!(known.len(), CATALOGUE.len());
    let missing: Vec<&str> = vocabulary
        .split_whitespace()
        .filter(|id| !known.contains(id))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
    for info in CATALOGUE {
        let texts = [info.summary, info.equation, info.source, info.condition];
        assert!(texts.iter().all(|text| !text.is_empty()), "{}", info.id);
        assert!(!info.channels.is_empty(), "{}", info.id);
        assert!(!info.parameters.is_empty(), "{}", info.id);
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

/// A law over `driver`, with these lists.
fn law(effect: &str, acts_on: &str, driver: &str, lists: [(&str, Parameter); 2]) -> RobotModel {
    let text = |name: &str, word: &str| (name.to_owned(), Parameter::Text(word.to_owned()));
    let lists = lists.map(|(name, list)| (name.to_owned(), list));
    let mut model = RobotModel::default();
    model.effects.push(EffectSpec {
        effect: effect.to_owned(),
        parameters: [text("acts_on", acts_on), text("driver", driver)]
            .into_iter()
            .chain(lists)
            .collect(),
    });
    model
}

#[test]
fn an_invalid_table_is_rejected_in_one_line_with_its_remedy() {
    let list = |values: &[f64]| Parameter::List(values.to_vec());
    let force = |knots: Parameter, values: Parameter| {
        let lists = [("knots", knots), ("values", values)];
        let model = law("force_law", "surge_force", "v", lists);
        Robot::new(&model).unwrap_err().to_string()
    };
    let long: Vec<f64> = (0..65).map(f64::from).collect();
    let cases = [
        (
            force(list(&[]), list(&[])),
            "effects.force_law.knots: has 0 values; give from 1 to 64",
        ),
        (
            force(list(&long), list(&long)),
            "effects.force_law.knots: has 65 values; give from 1 to 64",
        ),
        (
            force(list(&[0.0, 0.5, 0.5]), list(&[0.0; 3])),
            "effects.force_law.knots[2]: is 0.5, not larger than the 0.5 before it; give numbers that \
             increase",
        ),
        (
            force(list(&[0.0, f64::NAN]), list(&[0.0; 2])),
            "effects.force_law.knots[1]: is NaN; give a number from -1000000 to 1000000",
        ),
        (
            force(list(&[0.0, 1.0]), list(&[0.0])),
            "effects.force_law.values: has 1 values; give as many as knots: 2",
        ),
        (
            force(Parameter::Number(1.0), list(&[0.0])),
            "effects.force_law.knots: is 1; give a list of numbers, such as [0.0, 0.5]",
        ),
    ];
    for (error, expected) in cases {
        assert_eq!(error, expected);
    }
    let lists = || [("knots", list(&[0.0])), ("values", list(&[0.0]))];
    for driver in ["wheel_angle", "position", "torque", "time_at_rest"] {
        let error = Robot::new(&law("motion_law", "speed", driver, lists())).unwrap_err();
        let expected = format!(
            "effects.motion_law.driver: is \"{driver}\"; give one of t, v, w, heading, x, y"
        );
        assert_eq!(error.to_string(), expected);
    }
    let number = RobotModel::default().with("force_law", &[("acts_on", 1.0)]);
    assert_eq!(
        Robot::new(&number).unwrap_err().to_string(),
        "effects.force_law.acts_on: is \"1\"; give one of surge_force, yaw_moment"
    );
    let mut listed = RobotModel::default();
    listed.effects.push(EffectSpec {
        effect: "slip_ratio".to_owned(),
        parameters: vec![("ratio".to_owned(), list(&[0.1]))],
    });
    assert_eq!(
        Robot::new(&listed).unwrap_err().to_string(),
        "effects.slip_ratio.ratio: is a list; give a number"
    );
}

#[test]
fn laws_and_slip_ratios_are_refused_where_they_cannot_act() {
    let list = |values: &[f64]| Parameter::List(values.to_vec());
    let lists = || [("knots", list(&[0.0])), ("values", list(&[0.1]))];
    let robot = Robot::new(&law("motion_law", "speed", "v", lists())).unwrap();
    assert_eq!(robot.accepts(CommandKind::Speed), Ok(()));
    assert_eq!(
        robot.accepts(CommandKind::Torque).unwrap_err().to_string(),
        "effects.motion_law: needs commanded wheel speeds, and a torque command is given; list a \
         force_law, or command wheel speeds or twists"
    );
    let mut kinematic = law("force_law", "yaw_moment", "w", lists());
    kinematic.robot.body_mass_kg = None;
    assert_eq!(
        Robot::new(&kinematic).unwrap_err().place,
        "robot.body_mass_kg"
    );
    let slip = [("ratio", 0.9), ("asymmetry", 0.3)];
    let error = Robot::new(&RobotModel::default().with("slip_ratio", &slip)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "effects.slip_ratio.asymmetry: leaves a wheel with a slip ratio of 1.05; give numbers that \
         leave both wheels at 0.98 or less"
    );
}

#[test]
fn a_table_may_occur_twice() {
    let list = |values: &[f64]| Parameter::List(values.to_vec());
    let lists = [("knots", list(&[0.0, 1.0])), ("values", list(&[0.0, -0.5]))];
    let mut model = law("force_law", "surge_force", "v", lists);
    let again = model.effects[0].clone();
    model.effects.push(again);
    assert!(Robot::new(&model).is_ok());
}
