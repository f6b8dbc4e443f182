//! Known changes in copies of a recording, and how answers to them are scored.

#![allow(clippy::unwrap_used, reason = "a failed expectation fails the test")]

use slipstream_bus::RobotModel;
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command, Pose, Robot, Stream, Wheels};
use slipstream_trial::answer::parse;
use slipstream_trial::diagnosis_process::DiagnosisRun;
use slipstream_trial::grade::TrialGrade;
use slipstream_trial::own::{Change, make, score};

const RADIUS_M: f64 = 0.1;
const HALF_TRACK_M: f64 = 0.3;

fn model() -> RobotModel {
    let mut model = RobotModel::default();
    model.robot.wheel_radius_m = RADIUS_M;
    model.robot.half_track_m = HALF_TRACK_M;
    model
}

fn stream<V>(t_s: &[f64], values: V) -> Stream<V> {
    Stream {
        t_s: t_s.to_vec(),
        values,
        unknown: Vec::new(),
    }
}

fn robot() -> Robot {
    let t_s: Vec<f64> = (0..200).map(|k| 0.1 * f64::from(k)).collect();
    let mut robot = Robot::named("r1");
    let of = |f: fn(f64) -> f64| t_s.iter().map(|t| f(*t)).collect::<Vec<f64>>();
    robot.command = Some(stream(
        &t_s,
        Command::Twist {
            v_m_s: of(|t| 0.2 * t.sin()),
            w_rad_s: of(|t| 0.1 * t.cos()),
        },
    ));
    robot.wheels = Some(stream(
        &t_s,
        Wheels::Ticks {
            right: t_s.iter().map(|t| Some((1000.0 * t) as i64)).collect(),
            left: t_s.iter().map(|t| Some((900.0 * t) as i64)).collect(),
        },
    ));
    robot.pose = Some(stream(
        &t_s,
        Pose {
            x_m: of(|t| t),
            y_m: of(|_| 0.0),
            yaw_rad: Some(of(|t| 0.1 * t)),
        },
    ));
    robot
}

#[test]
fn changes_are_exact() {
    let model = model();
    let changed = |change: Change| {
        let mut own = robot();
        change.apply(&mut own, &model);
        own
    };
    let late = changed(Change::PoseLate(0.05)).pose.unwrap();
    assert!((late.t_s[3] - 0.35).abs() < 1e-12);
    // a command that acts later was given earlier
    let late = changed(Change::CommandLate(0.05)).command.unwrap();
    assert!((late.t_s[3] - 0.25).abs() < 1e-12);
    let moved = changed(Change::Offset([0.5, 0.0])).pose.unwrap().values;
    let yaw = 0.1 * 10.0_f64;
    assert!((moved.x_m[100] - (10.0 + 0.5 * yaw.cos())).abs() < 1e-12);
    assert!((moved.y_m[100] - 0.5 * yaw.sin()).abs() < 1e-12);
    // a larger wheel turns less on the same way
    let Wheels::Ticks { right, left } = changed(Change::Radius([1.25, 1.0])).wheels.unwrap().values
    else {
        panic!("ticks stay ticks");
    };
    assert_eq!((right[100], left[100]), (Some(8000), Some(9000)));
    // what a wheel loses was added to what it is told, and a robot that is told to stand stands
    let zoned = changed(Change::DeadZone(0.4)).command.unwrap().values;
    let Command::Twist { v_m_s, w_rad_s } = zoned else {
        panic!("twists stay twists");
    };
    let t = 10.0_f64;
    let [v, w] = [0.2 * t.sin(), 0.1 * t.cos()];
    for side in [1.0, -1.0] {
        let told = (v + side * HALF_TRACK_M * w) / RADIUS_M;
        let now = (v_m_s[100] + side * HALF_TRACK_M * w_rad_s[100]) / RADIUS_M;
        assert!((now - told - 0.4 * told.signum()).abs() < 1e-9);
    }
}

#[test]
fn copies_are_written_and_answers_scored_as_changes() {
    let folder = tempfile::tempdir().unwrap();
    let model = model();
    let recording = Recording {
        name: "own".to_owned(),
        robots: vec![robot()],
        ..Recording::default()
    };
    let trial = make(&recording, &model, folder.path()).unwrap();
    let nulls = trial.cases.iter().filter(|own| own.change.is_none());
    // itself, gaps, outliers, origin of time, and the halves both ways round
    assert_eq!(nulls.count(), 6);
    for case in &trial.cases {
        for folder in &case.folders {
            assert!(slipstream_recording::read(folder).is_ok(), "{folder:?}");
        }
    }
    // an answer that knows everything, but for one change that it misses and one null that it takes for a change
    let missed = trial
        .cases
        .iter()
        .position(|own| own.change.is_some())
        .unwrap();
    let answers = trial.cases.iter().enumerate().map(|(at, case)| {
        let change = case.change.filter(|_| at != missed);
        let alarm = (at == 0).then_some(Change::PoseLate(0.1));
        DiagnosisRun {
            answer: Ok(parse(&answer(change.or(alarm))).unwrap()),
            refused: false,
            seconds: 1.0,
        }
    });
    let report = score("own", &trial.cases, answers.collect());
    assert_eq!(report.trial.false_alarms, 1);
    assert_eq!(report.trial.missed, 1);
    assert_eq!(report.trial.each[missed].score.grade, TrialGrade::Missed);
    assert_eq!(report.trial.exact, trial.cases.len() - 2);
    let late = report
        .detectable
        .iter()
        .find(|own| own.effect == "pose_latency")
        .unwrap();
    // the smallest size was missed
    assert_eq!(late.smallest, Some(late.tried[1].0));
}

/// The JSON of an answer that names a change since a robot whose every number was 1.5.
fn answer(change: Option<Change>) -> String {
    let Some(change) = change else {
        return r#"{"verdict": "match", "findings": []}"#.to_owned();
    };
    let factor = matches!(
        change,
        Change::Radius(_) | Change::Counts(_) | Change::Gain(_)
    );
    let parameters: Vec<String> = change
        .parameters()
        .into_iter()
        .map(|(name, size)| {
            let now = if factor { 1.5 * size } else { 1.5 + size };
            let [low, high] = [now - 1e-6, now + 1e-6];
            format!(
                r#"{{"name": "{name}", "nominal": 1.5, "estimate": {now}, "ci95": [{low}, {high}]}}"#
            )
        })
        .collect();
    let info = slipstream_sim::effects::find(change.effect()).unwrap();
    format!(
        r#"{{"verdict": "explained", "findings": [{{"robot": "r1", "effect": "{}", "parameters": [{}],
            "where": {{"channel": "{}", "intervals_s": []}}, "confused_with": []}}]}}"#,
        change.effect(),
        parameters.join(", "),
        info.channels[0].name()
    )
}
