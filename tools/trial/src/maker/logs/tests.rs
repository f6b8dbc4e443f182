//! Cases of the plan `logs`: reproducible, as drawn, and true to their labels.

use super::log::{Log, LogEffect, Run, Source};
use super::make::{draw, make};
use super::nuisances::{Apply, TABLE};
use super::plant::Floor;
use super::robot::{PoseKind, WheelKind};
use crate::answer::parse;
use crate::grade::{TrialGrade, grade};
use crate::label::{DiagnosisVerdict, Label, Labels, ParameterValue, to_text};
use crate::maker::case::MadeCase;
use crate::maker::manoeuvre::CommandKind;
use crate::maker::random::RandomStream;
use slipstream_recording::recording::{Robot, Wheels};

/// A log of three drives with every stream, without effects and nuisances.
fn plain() -> Log {
    let mut log = Log::plain(5);
    log.streams.command = Some(CommandKind::Twist);
    log.streams.wheels = Some(WheelKind::Ticks);
    log.streams.pose = Some(PoseKind::Full);
    log.streams.gyro = true;
    let run = Run {
        duration_s: 15.0,
        floor: Floor::default(),
        latency_s: [0.0; 4],
    };
    log.runs = vec![run.clone(), run.clone(), run];
    log
}

/// The plain log with one nuisance that acts on the case as a whole.
fn with(name: &str) -> Log {
    let mut log = plain();
    let nuisance = TABLE.iter().find(|nuisance| nuisance.name == name).unwrap();
    let Apply::Case(apply) = nuisance.apply else {
        panic!("{name} acts on rows");
    };
    assert!(apply(&mut log, 0.5, &mut RandomStream::new(1, 0)), "{name}");
    log
}

fn label(log: &Log) -> Label {
    make(log, "case").label
}

/// Effects of a label with their runs.
fn labelled(label: &Label) -> Vec<(&str, Vec<&str>)> {
    let effects = label.effects.iter();
    effects
        .map(|own| {
            (
                own.effect.as_str(),
                own.runs.iter().map(String::as_str).collect(),
            )
        })
        .collect()
}

/// All bytes of a case: its recording as it is written, its model and its label.
fn bytes(made: &MadeCase) -> Vec<Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("case");
    slipstream_recording::write_folder(&made.recording, &place).unwrap();
    let mut all = vec![
        to_text(&Labels::from([("case".to_owned(), made.label.clone())]))
            .unwrap()
            .into_bytes(),
        format!("{:?}", made.model).into_bytes(),
        std::fs::read(place.join("recording.toml")).unwrap(),
    ];
    for robot in &made.recording.robots {
        for file in ["command", "wheels", "pose", "imu"] {
            all.extend(std::fs::read(place.join(&robot.name).join(format!("{file}.csv"))).ok());
        }
    }
    all
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    for seed in [1, 2, 3] {
        let one = bytes(&make(&draw(seed), "case"));
        assert_eq!(one, bytes(&make(&draw(seed), "case")));
        assert_ne!(one, bytes(&make(&draw(seed + 100), "case")));
    }
}

#[test]
fn a_third_of_the_cases_have_no_effect_and_everything_is_drawn() {
    let drawn: Vec<Log> = (0..600).map(|seed| draw(1000 * seed)).collect();
    let nulls = drawn
        .iter()
        .filter(|log| log.effects.is_empty() && log.plant.turn_loss_m == 0.0);
    let share = nulls.count() as f64 / 600.0;
    // 2 % of deviation
    assert!((0.33..0.55).contains(&share), "{share}");
    for (row, nuisance) in TABLE.iter().enumerate() {
        let with = drawn
            .iter()
            .filter(|log| log.nuisances.iter().any(|own| own.row == row));
        assert!(with.count() >= 5, "{}", nuisance.name);
    }
    for id in [
        "wheel_radius",
        "track_width",
        "slip_ratio",
        "pose_offset",
        "pose_latency",
        "wheels_latency",
        "imu_latency",
        "encoder_scale",
        "actuator_delay",
        "actuator_lag",
        "motor_gain",
        "command_dead_zone",
        "command_dead_band",
        "command_saturation",
        "clock_drift",
        "supply_sag",
    ] {
        assert!(drawn.iter().any(|log| log.conceals(&[id])), "{id}");
    }
}

#[test]
fn a_null_without_nuisances_is_a_match() {
    let label = label(&plain());
    assert_eq!(
        (label.verdict, label.nuisances.len()),
        (DiagnosisVerdict::Match, 0)
    );
    let graded = |text: &str| grade(&label, &parse(text).unwrap()).grade;
    assert_eq!(graded(r#"{"verdict": "match"}"#), TrialGrade::Exact);
    assert_eq!(
        graded(r#"{"verdict": "unexplained"}"#),
        TrialGrade::FalseAlarm
    );
    let named = r#"{"verdict": "explained", "findings": [{"robot": "r1", "effect": "track_width",
        "where": {"channel": "yaw"}}]}"#;
    assert_eq!(graded(named), TrialGrade::FalseAlarm);
}

/// Angles of both wheels at every row (rad).
fn angles(robot: &Robot) -> Vec<[f64; 2]> {
    let Some(Wheels::Ticks { right, left }) = robot.wheels.as_ref().map(|rows| &rows.values) else {
        panic!("no counters");
    };
    let step = std::f64::consts::TAU / robot.encoder_counts_per_rev.unwrap();
    let angle = |count: &Option<i64>| count.unwrap() as f64 * step;
    right
        .iter()
        .zip(left)
        .map(|(r, l)| [angle(r), angle(l)])
        .collect()
}

/// Turn of a robot (rad) by its wheels and by its poses, in its first run.
fn turns(log: &Log) -> [f64; 2] {
    let made = make(log, "case");
    let robot = &made.recording.robots[0];
    let angles = angles(robot);
    let (first, last) = (angles[0], angles[angles.len() - 1]);
    let [_, by_wheels] = log.robot.twist([last[0] - first[0], last[1] - first[1]]);
    let yaw = robot.pose.as_ref().unwrap().values.yaw_rad.clone().unwrap();
    let steps = yaw.windows(2).map(|two| {
        (two[1] - two[0] + 9.0 * std::f64::consts::PI) % std::f64::consts::TAU
            - std::f64::consts::PI
    });
    [by_wheels, steps.sum()]
}

#[test]
fn wheels_and_poses_agree_by_the_nominal_model_and_differ_by_the_effect() {
    let mut log = plain();
    log.course = super::course::Course::Teleoperated;
    let [wheels, poses] = turns(&log);
    assert!(
        wheels.abs() > 0.2 && (wheels - poses).abs() < 0.05,
        "{wheels} {poses}"
    );
    log.plant.track_scale = 1.5;
    let [wheels, poses] = turns(&log);
    assert!((wheels - 1.5 * poses).abs() < 0.07, "{wheels} {poses}");
}

#[test]
fn counters_with_a_fraction_are_logged_as_angles() {
    let log = with("fractional_counts");
    assert!(log.streams.counts.fract() > 0.05);
    let made = make(&log, "case");
    assert!(matches!(
        made.recording.robots[0].wheels.as_ref().unwrap().values,
        Wheels::Angle { .. }
    ));
    assert_eq!(made.model.encoder, None);
}

#[test]
fn mean_speeds_are_those_of_the_interval_before() {
    let (mut mean, mut now) = (with("mean_speeds"), with("momentary_speeds"));
    for log in [&mut mean, &mut now] {
        log.streams.counts = 4e5;
    }
    let column = |log: &Log| match &make(log, "case").recording.robots[0]
        .wheels
        .as_ref()
        .unwrap()
        .values
    {
        Wheels::Speed { right_rad_s, .. } => right_rad_s.clone(),
        _ => panic!("no speeds"),
    };
    let (mean, now) = (column(&mean), column(&now));
    assert!(mean.iter().zip(&now).any(|(a, b)| (a - b).abs() > 1e-3));
    // While the speed is even, both are the same: most rows.
    let close = mean
        .iter()
        .zip(&now)
        .filter(|(a, b)| (*a - *b).abs() < 0.02 * (1.0 + b.abs()));
    assert!(close.count() * 10 > mean.len() * 3);
    // The mean of an interval is late by half of it.
    assert!(
        label(&with("mean_speeds"))
            .allowed
            .contains(&"wheels_latency".to_owned())
    );
}

#[test]
fn a_momentary_gyro_is_no_mean() {
    let column = |log: &Log| {
        let robot = &make(log, "case").recording.robots[0];
        robot.imu.clone().unwrap().values.gz_rad_s.unwrap()
    };
    let (mean, momentary) = (column(&plain()), column(&with("momentary_gyro")));
    let differ = mean
        .iter()
        .zip(&momentary)
        .filter(|(a, b)| (*a - *b).abs() > 1e-5);
    // While the robot turns evenly, and at rest, both are the same.
    assert!((1..mean.len()).contains(&differ.count()));
}

#[test]
fn a_reference_without_heading_has_no_yaw() {
    let made = make(&with("no_heading"), "case");
    assert!(
        made.recording
            .robots
            .iter()
            .all(|own| own.pose.as_ref().unwrap().values.yaw_rad.is_none())
    );
}

#[test]
fn sparse_poses_are_one_before_and_one_after() {
    let log = with("sparse_poses");
    for robot in &make(&log, "case").recording.robots {
        let times = &robot.pose.as_ref().unwrap().t_s;
        assert_eq!(times.len(), 2);
        assert!(times[1] - times[0] > 14.0);
    }
}

#[test]
fn a_robot_that_skids_has_a_track_in_its_label() {
    let label = label(&with("skid_track"));
    assert_eq!(labelled(&label), [("track_width", vec![])]);
    let ParameterValue::Number(scale) = label.effects[0].parameters["scale"] else {
        panic!("no number");
    };
    assert!((1.1..2.2).contains(&scale), "{scale}");
    assert!(label.effects[0].tolerances["scale"] > 0.008);
}

#[test]
fn speed_lost_in_turns_is_unknown_with_its_driver() {
    let label = label(&with("turn_loss"));
    assert_eq!(label.verdict, DiagnosisVerdict::Unexplained);
    assert_eq!(label.unknown.unwrap().driver, ["w"]);
}

#[test]
fn a_slow_drive_excuses_a_lag() {
    let log = with("slow_drive");
    assert!(log.plant.slow[0] > 0.04);
    let label = label(&log);
    assert!(label.effects.is_empty() && label.allowed.contains(&"actuator_lag".to_owned()));
}

#[test]
fn a_saturation_is_below_what_is_told() {
    let log = with("saturating_drive");
    let told = log.told_rad_s();
    assert!(log.plant.saturation_rad_s < told[told.len() - 1]);
    assert_eq!(labelled(&label(&log)), [("command_saturation", vec![])]);
}

#[test]
fn floors_differ_from_the_second_run_on() {
    let slips = label(&with("floor_by_run"));
    assert_eq!(
        labelled(&slips),
        [("slip_ratio", vec!["r2"]), ("slip_ratio", vec!["r3"])]
    );
}

#[test]
fn latencies_differ_by_run() {
    let log = with("latency_by_run");
    let late = label(&log);
    let runs: Vec<_> = labelled(&late)
        .into_iter()
        .map(|(id, runs)| (id, runs[0]))
        .collect();
    assert_eq!(
        runs,
        [
            ("pose_latency", "r1"),
            ("pose_latency", "r2"),
            ("pose_latency", "r3")
        ]
    );
    let at = Source::Pose as usize;
    assert_ne!(log.runs[0].latency_s[at], log.runs[1].latency_s[at]);
}

#[test]
fn a_late_gyro_is_in_the_label() {
    assert_eq!(
        labelled(&label(&with("late_gyro"))),
        [("imu_latency", vec![])]
    );
}

#[test]
fn noise_moves_the_robot_and_is_no_effect() {
    for name in ["steady_noise", "noise_with_speed", "gusts"] {
        let mut log = with(name);
        assert_eq!(label(&log).verdict, DiagnosisVerdict::Match);
        let noisy = turns(&log);
        log.plant.noise.clear();
        assert_ne!(noisy, turns(&log), "{name}");
    }
}

#[test]
fn clocks_differ_by_less_than_a_drift() {
    let log = with("second_clock");
    let drift = log.sensors.drift[Source::Pose as usize].abs();
    assert!(drift > 0.0 && drift <= 5e-5);
    assert!(label(&log).effects.is_empty());
}

#[test]
fn time_can_count_from_elsewhere() {
    let log = with("other_epoch");
    let made = make(&log, "case");
    assert!(made.recording.robots[0].command.as_ref().unwrap().t_s[0] >= 1.3e9);
}

#[test]
fn a_lag_of_rows_is_added_to_the_latency_in_the_label() {
    let mut log = plain();
    let row = TABLE
        .iter()
        .position(|own| own.name == "saw_tooth_lag")
        .unwrap();
    log.nuisances = vec![super::log::DrawnNuisance {
        row,
        size: 1.0,
        on: vec![Source::Pose],
    }];
    assert!(label(&log).allowed.contains(&"pose_latency".to_owned()));
    log.sensors.latency_s[Source::Pose as usize] = 0.1;
    log.effects
        .push(LogEffect::new("pose_latency", &[("latency_s", 0.1)]));
    let label = label(&log);
    let period_s = log.streams.periods_s[Source::Pose as usize];
    let ParameterValue::Number(latency_s) = label.effects[0].parameters["latency_s"] else {
        panic!("no number");
    };
    // a tooth of 1.5 periods is 0.75 periods on average
    assert!(
        (latency_s - 0.1 - 0.75 * period_s).abs() < 0.15 * period_s,
        "{latency_s}"
    );
    assert!(!label.allowed.contains(&"pose_latency".to_owned()));
    assert_eq!(label.nuisances, ["saw_tooth_lag"]);
}
