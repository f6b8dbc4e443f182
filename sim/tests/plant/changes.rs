//! Robots that become others while they drive.

use slipstream_bus::experiment::{ParameterValue, Parameters};
use slipstream_bus::{EffectSpec, Experiment, Parameter, RobotModel, Settings};
use slipstream_sim::effects::{CATALOGUE, Domain, Info};
use slipstream_sim::{Command, Robot, Setup, World};

const STEP_NS: i64 = 1_000_000;

fn world(model: &RobotModel) -> World {
    let setup = Setup {
        name: "r1".to_owned(),
        model: model.clone(),
        pose: [0.0; 3],
        sensors: slipstream_bus::Sensors::default(),
    };
    World::new(&[setup], 1).unwrap()
}

fn drive(world: &mut World, steps: u32) {
    let torque = Command::Torque {
        right_nm: 0.03,
        left_nm: 0.02,
    };
    for _ in 0..steps {
        world.step(STEP_NS, &[torque]);
    }
}

/// An effect with numbers that the catalogue itself tries.
fn spec(info: &Info) -> EffectSpec {
    let mut has_alternative = false;
    let given = info.parameters.iter().filter(|own| {
        let is_left_out = own.optional || (own.alternative && has_alternative);
        has_alternative |= own.alternative;
        !is_left_out
    });
    let parameters = given.map(|own| {
        let value = match own.domain {
            Domain::Number { probes, lower, .. } => {
                Parameter::Number(probes.first().copied().unwrap_or(lower))
            }
            Domain::Text(words) => Parameter::Text(words[0].to_owned()),
            Domain::List { increasing, .. } if increasing => Parameter::List(vec![0.0, 1.0]),
            Domain::List { .. } => Parameter::List(vec![0.0, 0.01]),
        };
        (own.name.to_owned(), value)
    });
    EffectSpec {
        effect: info.id.to_owned(),
        parameters: parameters.collect(),
    }
}

/// Whichever effect begins, the robot goes on from where it was, and the counters run on.
#[test]
fn every_effect_begins_without_a_jump() {
    let plain = RobotModel::paper_with_slip();
    let mut begun = 0;
    for info in CATALOGUE {
        let mut model = plain.clone();
        model.effects.retain(|own| own.effect != info.id);
        model.effects.push(spec(info));
        let Ok(robot) = Robot::new(&model) else {
            continue;
        };
        let mut world = world(&plain);
        drive(&mut world, 800);
        let (before, counts) = (world.truth(0), world.encoder_counts(0));
        world.replace(0, robot);
        let after = world.truth(0);
        assert_eq!(before.pose, after.pose, "{}", info.id);
        assert_eq!(before.wheel_angle_rad, after.wheel_angle_rad, "{}", info.id);
        for (a, b) in before.velocity.iter().zip(after.velocity) {
            assert!((a - b).abs() < 0.02, "{}: {a} {b}", info.id);
        }
        for (a, b) in counts.iter().zip(world.encoder_counts(0)) {
            assert!((a - b).abs() <= 1, "{}: {a} {b}", info.id);
        }
        drive(&mut world, 500);
        assert_eq!(world.first_not_finite(), None, "{}", info.id);
        begun += 1;
    }
    assert!(begun >= 28, "{begun} effects");
}

/// A robot that is replaced by itself drives as if nothing had been done.
#[test]
fn the_same_robot_drives_on() {
    let lagged = RobotModel::paper_with_slip()
        .with("actuator_lag", &[("time_constant_s", 0.05)])
        .with("actuator_delay", &[("delay_s", 0.02)])
        .with("backlash", &[("gap_rad", 0.05)]);
    for model in [RobotModel::paper_with_slip(), lagged] {
        let [mut one, mut other] = [world(&model), world(&model)];
        drive(&mut one, 700);
        drive(&mut other, 700);
        other.replace(0, Robot::new(&model).unwrap());
        drive(&mut one, 700);
        drive(&mut other, 700);
        let (a, b) = (one.truth(0), other.truth(0));
        for (a, b) in a.pose.iter().zip(b.pose) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}

/// An effect that begins in an experiment is that of the robot from then on, beside those that it had.
#[test]
fn effects_of_an_experiment_begin_at_their_time() {
    let text = |own: &str| ParameterValue::Text(own.to_owned());
    let table = Parameters::from([
        ("at_s".to_owned(), ParameterValue::Number(0.5)),
        ("robot".to_owned(), text("r1")),
        ("effect".to_owned(), text("viscous_drag")),
        ("coefficient".to_owned(), ParameterValue::Number(5.0)),
    ]);
    let settings = Settings {
        changes: vec![table.into()],
        ..Settings::single()
    };
    let model = RobotModel::paper_with_slip();
    let experiment = Experiment::new(settings, &model);
    let mut changes = slipstream_sim::run::Changes::new(&experiment).unwrap();
    let [mut one, mut other] = [world(&model), world(&model)];
    for step in 0..1000 {
        assert_eq!(
            one.truth(0).pose == other.truth(0).pose,
            step <= 500,
            "step {step}"
        );
        changes.apply(&mut other);
        drive(&mut one, 1);
        drive(&mut other, 1);
    }
}
