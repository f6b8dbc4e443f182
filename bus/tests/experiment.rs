//! Experiments as a library user builds them: from settings and a model, encoded, decoded, checked.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use slipstream_bus::experiment::Topology;
use slipstream_bus::experiment::{Law, Protocol, TorqueLimit};
use slipstream_bus::{Experiment, RobotModel, Settings};

fn built_in() -> [Settings; 5] {
    [
        Settings::default(),
        Settings::single(),
        Settings::circle(),
        Settings::figure_eight(),
        Settings::lane_change(),
    ]
}

#[test]
fn the_built_in_experiments_are_valid() {
    for settings in built_in() {
        assert_eq!(settings.validate(), Ok(()), "{}", settings.name);
    }
}

/// The launcher hands the experiment to the processes as postcard.
#[test]
fn an_experiment_survives_postcard() {
    for settings in built_in() {
        let model = RobotModel::paper_with_slip().with("payload", &[("mass_kg", 0.5)]);
        let mut experiment = Experiment::new(settings, &model);
        experiment.half_round_trips_ns = vec![Some(1_000_000), None];
        let bytes = postcard::to_allocvec(&experiment).unwrap();
        let decoded: Experiment = postcard::from_bytes(&bytes).unwrap();
        assert_eq!(decoded, experiment);
    }
}

/// Section 4 of the paper: r1 at x = 0.6096 m, r2 at the origin, r3 behind it.
#[test]
fn the_platoon_starts_where_the_papers_does() {
    let experiment = Experiment::new(Settings::default(), &RobotModel::default());
    let robots: Vec<_> = experiment
        .robots
        .iter()
        .map(|robot| (robot.name.as_str(), robot.pose[0]))
        .collect();
    assert_eq!(robots, [("r1", 0.6096), ("r2", 0.0), ("r3", -0.6096)]);
}

#[test]
fn an_invalid_combination_names_its_key_and_a_remedy() {
    let mut settings = Settings::default();
    settings.control.law = Law::ComputedTorque;
    settings.control.torque_limit = TorqueLimit::Outer;
    let error = settings.validate().unwrap_err();
    assert_eq!(error.place, "control.torque_limit");
    assert!(error.remedy.contains("adaptive"), "{error}");
}

#[test]
fn the_protocol_decides_whether_the_last_robot_sends_to_the_first() {
    let mut settings = Settings::default();
    let last_to = |settings: &Settings| {
        let experiment = Experiment::new(settings.clone(), &RobotModel::default());
        Topology::new(&experiment).heard_by(2).first().copied()
    };
    assert_eq!(last_to(&settings), Some(0));
    settings.links.protocol = Protocol::Periodic;
    assert_eq!(last_to(&settings), None);
    assert_eq!(Topology::of(&Settings::single()).heard_by(0), []);
}
