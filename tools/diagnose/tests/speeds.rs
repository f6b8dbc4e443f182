//! What the diagnosis says of a robot without known masses that is told speeds, and whose truth is known.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on says so and stops"
)]

mod common;

use slipstream_answer::{Answer, Verdict};
use slipstream_bus::RobotModel;
use slipstream_diagnose::{Request, diagnose};
use slipstream_recording::Recording;
use slipstream_recording::recording::{Robot, Wheels};

use common::{noise, recording};

const RADIUS_M: f64 = 0.05;
const HALF_TRACK_M: f64 = 0.12;
const STEP_S: f64 = 1e-3;

/// What the robot really is.
#[derive(Clone, Copy)]
struct Truth {
    delay_s: f64,
    gain: f64,
    counts: f64,
    camera_m: [f64; 2],
}

const NOMINAL: Truth = Truth {
    delay_s: 0.0,
    gain: 1.0,
    counts: 1.0,
    camera_m: [0.0; 2],
};

fn model() -> RobotModel {
    slipstream_testkit::kinematic(RADIUS_M, HALF_TRACK_M)
}

/// Commanded wheel speeds (rad/s) from a time on: new ones every tenth of a second.
fn told(t_s: f64) -> [f64; 2] {
    if t_s < 0.0 {
        return [0.0; 2];
    }
    let t_s = (t_s / 0.1).floor() * 0.1;
    let v = 0.3 + 0.15 * (0.9 * t_s).sin() + 0.05 * (4.1 * t_s).sin();
    let w = 0.8 * (0.5 * t_s).sin() + 0.3 * (2.7 * t_s).cos();
    [v + HALF_TRACK_M * w, v - HALF_TRACK_M * w].map(|rim| rim / RADIUS_M)
}

/// Thirty seconds of `truth`: commands at 10 Hz, wheels at 50 Hz, poses at 20 Hz with 2 mm and 4 mrad.
fn recorded(truth: Truth) -> Recording {
    recorded_with(truth, 0.0)
}

/// The same, with other errors of the poses for each `seed`.
fn recorded_with(truth: Truth, seed: f64) -> Recording {
    let noise = |k: f64| noise(k + seed);
    let mut columns: [Vec<f64>; 10] = Default::default();
    let mut add = |from: usize, row: &[f64]| {
        row.iter()
            .zip(&mut columns[from..])
            .for_each(|(value, column)| column.push(*value));
    };
    let (mut angles, [mut x, mut y, mut yaw]) = ([0.0_f64; 2], [0.0, 0.0, 0.2_f64]);
    for k in 0..30_000_u32 {
        let t_s = f64::from(k) * STEP_S;
        if k % 100 == 0 {
            let [right, left] = told(t_s);
            add(0, &[t_s, right, left]);
        }
        if k % 20 == 0 {
            add(
                3,
                &[t_s, angles[0] * truth.counts, angles[1] * truth.counts],
            );
        }
        if k % 50 == 7 {
            let [along, across, turn] = [0.0, 0.3, 0.7].map(|part| noise(f64::from(k) + part));
            let [ox, oy] = truth.camera_m;
            let (sin, cos) = yaw.sin_cos();
            let at = [x + ox * cos - oy * sin, y + ox * sin + oy * cos];
            add(
                6,
                &[
                    t_s,
                    at[0] + 2e-3 * along,
                    at[1] + 2e-3 * across,
                    yaw + 4e-3 * turn,
                ],
            );
        }
        let speeds = told(t_s + STEP_S / 2.0 - truth.delay_s).map(|u| u * truth.gain);
        let way = RADIUS_M * f64::midpoint(speeds[0], speeds[1]) * STEP_S;
        let turn = RADIUS_M * (speeds[0] - speeds[1]) / (2.0 * HALF_TRACK_M) * STEP_S;
        angles = [0, 1].map(|i| angles[i] + speeds[i] * STEP_S);
        x += way * (yaw + turn / 2.0).cos();
        y += way * (yaw + turn / 2.0).sin();
        yaw += turn;
    }
    recording("speeds", columns)
}

fn diagnosed(truth: Truth, nominal: &RobotModel) -> (Answer, RobotModel) {
    common::diagnosed(recorded(truth), nominal).unwrap()
}

/// Effects and their parameters, by name.
fn found(answer: &Answer) -> Vec<(String, Vec<f64>)> {
    let mut all: Vec<(String, Vec<f64>)> = answer
        .findings
        .iter()
        .map(|finding| {
            let parameters = finding.parameters.iter();
            let values = parameters.filter_map(|p| p.estimate).collect();
            (finding.effect.clone(), values)
        })
        .collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

#[test]
fn a_robot_that_does_as_it_is_told_matches() {
    let (answer, _) = diagnosed(NOMINAL, &model());
    assert_eq!(
        answer.verdict,
        Verdict::Match,
        "{} {:?}",
        answer.statement,
        found(&answer)
    );
}

#[test]
fn a_late_and_weak_drive_and_a_camera_are_told_apart_and_then_match() {
    let truth = Truth {
        delay_s: 0.06,
        gain: 0.93,
        camera_m: [-0.08, 0.03],
        ..NOMINAL
    };
    let (answer, improved) = diagnosed(truth, &model());
    let all = found(&answer);
    let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        ["actuator_delay", "motor_gain", "pose_offset"],
        "{all:?}"
    );
    // the delay is known to less than a step of the simulation, the gain to what rounding leaves,
    // the camera to the mean of 600 poses
    assert!((all[0].1[0] - 0.06).abs() < 1e-3, "{all:?}");
    assert!(
        all[1].1.iter().all(|gain| (gain - 0.93).abs() < 1e-3),
        "{all:?}"
    );
    assert!((all[2].1[0] + 0.08).abs() < 3e-3, "{all:?}");
    assert!((all[2].1[1] - 0.03).abs() < 3e-3, "{all:?}");
    let place = answer.budget.iter().find(|own| own.unit == "m").unwrap();
    let sum: f64 = place.parts.iter().map(|part| part.share).sum();
    assert!((sum - place.before).abs() < 1e-9, "{place:?}");
    assert!(place.after < 0.2 * place.before, "{place:?}");
    let (again, _) = diagnosed(truth, &improved);
    assert_eq!(again.verdict, Verdict::Match, "{:?}", found(&again));
}

#[test]
fn encoders_that_count_too_much_are_neither_gain_nor_radius() {
    let truth = Truth {
        counts: 1.03,
        ..NOMINAL
    };
    let (answer, _) = diagnosed(truth, &model());
    let all = found(&answer);
    assert_eq!(all.len(), 1, "{all:?}");
    assert_eq!(all[0].0, "encoder_scale", "{all:?}");
    assert!(
        all[0].1.iter().all(|scale| (scale - 1.03).abs() < 1e-3),
        "{all:?}"
    );
}

/// A robot that does as it is told, without its commands; `poses_s` and `wheels_s` late.
fn late(poses_s: f64, wheels_s: f64) -> Recording {
    let mut recording = recorded(NOMINAL);
    let robot = &mut recording.robots[0];
    robot.command = None;
    let pose = robot.pose.as_mut().unwrap();
    pose.t_s.iter_mut().for_each(|t_s| *t_s += poses_s);
    let wheels = robot.wheels.as_mut().unwrap();
    wheels.t_s.iter_mut().for_each(|t_s| *t_s += wheels_s);
    recording
}

#[test]
fn a_delay_between_two_streams_is_named_as_between_them() {
    for (poses_s, wheels_s, effect, other) in [
        (0.0, 0.1, "wheels_latency", "pose_latency"),
        (0.1, 0.0, "pose_latency", "wheels_latency"),
    ] {
        let recording = late(poses_s, wheels_s);
        let ask = |nominal: &RobotModel| {
            let request = Request {
                recordings: std::slice::from_ref(&recording),
                against: &[],
                model_of: &|_| Some(nominal.clone()),
                excluded: &[],
                excluded_s: &[],
                progress: &|_| (),
            };
            diagnose(&request).unwrap()
        };
        let (answer, improved) = ask(&model());
        let all = found(&answer);
        assert_eq!(all.len(), 1, "{all:?}");
        assert_eq!(all[0].0, effect, "{all:?}");
        assert!((all[0].1[0] - 0.1).abs() < 5e-3, "{all:?}");
        let finding = &answer.findings[0];
        assert_eq!(finding.confused_with, [other]);
        for words in ["s behind, or the stamps of", "a command or a gyro"] {
            assert!(finding.statement.contains(words), "{}", finding.statement);
        }
        let (again, _) = ask(&improved[0].1);
        assert_eq!(again.verdict, Verdict::Match, "{:?}", found(&again));
    }
}

/// What changed from `before` to `today`, whose poses have other errors.
fn changed(before: Truth, today: Truth) -> Result<Answer, slipstream_bus::InputError> {
    let request = Request {
        recordings: &[recorded_with(today, 0.4)],
        against: &[recorded(before)],
        model_of: &|_| Some(model()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    };
    diagnose(&request).map(|(answer, _)| answer)
}

#[test]
fn what_both_recordings_share_is_no_change() {
    let truth = Truth {
        delay_s: 0.06,
        gain: 0.93,
        camera_m: [-0.08, 0.03],
        ..NOMINAL
    };
    let answer = changed(truth, truth).unwrap();
    assert_eq!(
        answer.verdict,
        Verdict::Match,
        "{} {:?}",
        answer.statement,
        found(&answer)
    );
    assert_eq!(answer.against, ["speeds"]);
}

#[test]
fn a_change_is_found_beside_what_is_shared_with_the_opposite_sign_the_other_way_round() {
    let before = Truth {
        gain: 0.93,
        camera_m: [-0.08, 0.03],
        ..NOMINAL
    };
    let today = Truth {
        camera_m: [0.02, 0.03],
        ..before
    };
    for (then, now, was, is) in [(before, today, -0.08, 0.02), (today, before, 0.02, -0.08)] {
        let answer = changed(then, now).unwrap();
        let names: Vec<&str> = answer.findings.iter().map(|f| f.effect.as_str()).collect();
        assert_eq!(names, ["pose_offset"], "{:?}", found(&answer));
        let finding = &answer.findings[0];
        let x = finding.parameters.iter().find(|p| p.name == "x_m").unwrap();
        // the mean of 600 poses of each recording, and what recordings of one machine may differ by
        assert!((x.nominal.unwrap() - was).abs() < 3e-3, "{x:?}");
        assert!((x.estimate.unwrap() - is).abs() < 6e-3, "{x:?}");
        let [low, high] = x.ci95.unwrap();
        assert!((low..=high).contains(&is), "{x:?}");
        let [low, high] = x.nominal_ci95.unwrap();
        assert!((low..=high).contains(&was), "{x:?}");
        let way = if is > was { "forward" } else { "back" };
        let words = format!("cm further {way}");
        assert!(finding.statement.contains(&words), "{}", finding.statement);
    }
}

#[test]
fn a_drive_that_became_slower_to_answer_is_named_alone() {
    let before = Truth {
        delay_s: 0.03,
        counts: 1.02,
        ..NOMINAL
    };
    let today = Truth {
        delay_s: 0.09,
        ..before
    };
    let answer = changed(before, today).unwrap();
    let all = found(&answer);
    assert_eq!(all.len(), 1, "{all:?}");
    assert_eq!(all[0].0, "actuator_delay", "{all:?}");
    assert!((all[0].1[0] - 0.09).abs() < 2e-3, "{all:?}");
}

/// What changed from a recording to a copy of it in which `change` was made.
fn changed_in_copy(change: impl Fn(&mut Robot)) -> Answer {
    let truth = Truth {
        gain: 0.93,
        camera_m: [-0.08, 0.03],
        ..NOMINAL
    };
    let original = recorded(truth);
    let mut copy = original.clone();
    change(&mut copy.robots[0]);
    let request = Request {
        recordings: &[copy],
        against: &[original],
        model_of: &|_| Some(model()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    };
    diagnose(&request).unwrap().0
}

#[test]
fn a_change_in_a_copy_is_found_far_below_what_differs_between_recordings() {
    // two recordings of a machine differ by 5 ms without a change
    let late_s = 6e-3;
    let answer = changed_in_copy(|robot| {
        let pose = robot.pose.as_mut().unwrap();
        pose.t_s.iter_mut().for_each(|t_s| *t_s += late_s);
    });
    let all = found(&answer);
    assert_eq!(all.len(), 1, "{all:?}");
    assert_eq!(all[0].0, "pose_latency", "{all:?}");
    assert!((all[0].1[0] - late_s).abs() < 2e-4, "{all:?}");
}

#[test]
fn a_copy_with_a_gap_and_an_outlier_matches_and_says_what_it_would_have_shown() {
    let answer = changed_in_copy(|robot| {
        let pose = robot.pose.as_mut().unwrap();
        pose.values.x_m[300] += 0.5;
        pose.t_s.drain(100..130);
        pose.values.x_m.drain(100..130);
        pose.values.y_m.drain(100..130);
        pose.values.yaw_rad.as_mut().unwrap().drain(100..130);
    });
    assert_eq!(
        answer.verdict,
        Verdict::Match,
        "{} {:?}",
        answer.statement,
        found(&answer)
    );
    let mut limits = answer.detectable.iter();
    let late = limits.find(|own| own.effect == "pose_latency").unwrap();
    let smallest_s = late.smallest.unwrap();
    assert!(smallest_s > 0.0 && smallest_s < 6e-3, "{late:?}");
}

#[test]
fn recordings_that_cannot_be_compared_are_refused_in_words() {
    let refused = |today: Recording, before: Recording, words: &str| {
        let request = Request {
            recordings: &[today],
            against: &[before],
            model_of: &|_| None,
            excluded: &[],
            excluded_s: &[],
            progress: &|_| (),
        };
        let error = diagnose(&request).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let own = || Recording {
        model: Some(model()),
        ..recorded(NOMINAL)
    };
    let mut other = own();
    other.model = Some(slipstream_testkit::kinematic(0.07, HALF_TRACK_M));
    refused(
        own(),
        other,
        "is another machine: wheel_radius_m = 0.05, and 0.07",
    );
    let mut other = own();
    other.robots[0].command = None;
    refused(
        own(),
        other,
        "is told speeds, and nothing in the recording from before",
    );
    let mut other = own();
    other.robots.push(Robot::named("r3"));
    other.robots[0].name = "r2".to_owned();
    refused(own(), other, "is not in speeds");
    let mut other = own();
    other.robots[0].pose = None;
    let mut today = own();
    today.robots[0].wheels = None;
    other.robots[0].wheels = None;
    refused(today, other, "shares no pose");
}

/// The same recording with other wheel angles.
fn with_wheels(mut recording: Recording, change: impl Fn(usize, f64) -> f64) -> Recording {
    let wheels = recording.robots[0].wheels.as_mut().unwrap();
    if let Wheels::Angle {
        right_rad,
        left_rad,
    } = &mut wheels.values
    {
        for side in [right_rad, left_rad] {
            side.iter_mut()
                .enumerate()
                .for_each(|(row, angle)| *angle = change(row, *angle));
        }
    }
    recording
}

#[test]
fn angles_that_wrap_or_restart_are_diagnosed_as_those_that_run_on() {
    let truth = Truth {
        delay_s: 0.12,
        ..NOMINAL
    };
    let answer = |recording: Recording| {
        let (answer, _) = common::diagnosed(recording, &model()).unwrap();
        let said: Vec<String> = answer.warnings.iter().map(|w| w.id.clone()).collect();
        (found(&answer), answer.held_out.nrmse_after, said)
    };
    let plain = answer(recorded(truth));
    assert!(plain.2.is_empty(), "{:?}", plain.2);
    let wrap = |_, angle: f64| angle.rem_euclid(std::f64::consts::TAU);
    let restart = |row, angle: f64| if row < 700 { angle + 400.0 } else { angle };
    for (changed, id) in [
        (with_wheels(recorded(truth), wrap), "angles_wrap"),
        (with_wheels(recorded(truth), restart), "counter_jumps"),
    ] {
        let (findings, after, said) = answer(changed);
        let names = |all: &[(String, Vec<f64>)]| -> Vec<String> {
            all.iter().map(|(name, _)| name.clone()).collect()
        };
        assert_eq!(names(&findings), names(&plain.0));
        assert!((findings[0].1[0] - 0.12).abs() < 1e-3, "{findings:?}");
        assert!((after - plain.1).abs() < 0.02, "{id}: {after}");
        assert!(
            said.iter().all(|said| said == id) && !said.is_empty(),
            "{said:?}"
        );
    }
}
