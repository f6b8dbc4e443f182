//! Wheel angles of any quality and scale. Better sensors give no worse answers: a lag of 0.1 s is found
//! whatever the steps of the wheel angles.
//!
//! It was lost with angles finer than 1.5 mrad. Most rows are steady and fitted a tiny noise; the few rows
//! behind each step of the command, which alone know the lag, then counted as outliers of no weight.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on says so and stops"
)]

mod common;

use slipstream_diagnose::{Answer, Request, Verdict, diagnose};
use slipstream_recording::Recording;
use slipstream_recording::recording::Wheels;

use common::recording;

const RADIUS_M: f64 = 0.05;
const HALF_TRACK_M: f64 = 0.12;
const LAG_S: f64 = 0.1;
const STEP_S: f64 = 2e-3;
const STEPS: u32 = 15_000;
/// Speeds (m/s) and turn rates (rad/s), two seconds each.
const TOLD: [[f64; 2]; 5] = [[0.3, 0.0], [0.3, 0.9], [0.1, -1.2], [0.4, 0.2], [-0.2, 0.6]];

/// Commanded speeds of both wheels (rad/s) in a step of the simulation.
fn told(step: u32) -> [f64; 2] {
    let [v, w] = TOLD[(step / 1000) as usize % TOLD.len()];
    [v + HALF_TRACK_M * w, v - HALF_TRACK_M * w].map(|rim| rim / RADIUS_M)
}

/// Thirty seconds of a drive with a lag: wheels at 50 Hz in steps of `rounding_rad` (0: exact), poses at
/// 20 Hz with 2 mm and 4 mrad.
fn recorded(lag_s: f64, rounding_rad: f64) -> Recording {
    let noise = |k: f64| 2.0 * ((k * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0) - 1.0;
    let rounded = |angle: f64| {
        if rounding_rad > 0.0 {
            (angle / rounding_rad).floor() * rounding_rad
        } else {
            angle
        }
    };
    let mut columns: [Vec<f64>; 10] = Default::default();
    let mut add = |from: usize, row: &[f64]| {
        let places = row.iter().zip(&mut columns[from..]);
        places.for_each(|(value, column)| column.push(*value));
    };
    let (mut speeds, mut angles) = ([0.0_f64; 2], [0.0_f64; 2]);
    let [mut x, mut y, mut yaw] = [0.0, 0.0, 0.2_f64];
    let decay = if lag_s > 0.0 {
        (-STEP_S / lag_s).exp()
    } else {
        0.0
    };
    for k in 0..STEPS {
        let (t_s, u) = (f64::from(k) * STEP_S, told(k));
        if k % 50 == 0 {
            add(0, &[t_s, u[0], u[1]]);
        }
        if k % 10 == 0 {
            add(3, &[t_s, rounded(angles[0]), rounded(angles[1])]);
        }
        if k % 25 == 7 {
            let [a, b, c] = [0.0, 0.3, 0.7].map(|part| noise(f64::from(k) + part));
            add(6, &[t_s, x + 2e-3 * a, y + 2e-3 * b, yaw + 4e-3 * c]);
        }
        // the exact solution over a step, in which the command holds
        let turned = [0, 1].map(|i| u[i] * STEP_S + (speeds[i] - u[i]) * lag_s * (1.0 - decay));
        speeds = [0, 1].map(|i| u[i] + (speeds[i] - u[i]) * decay);
        angles = [0, 1].map(|i| angles[i] + turned[i]);
        let way = RADIUS_M * f64::midpoint(turned[0], turned[1]);
        let turn = RADIUS_M * (turned[0] - turned[1]) / (2.0 * HALF_TRACK_M);
        x += way * (yaw + turn / 2.0).cos();
        y += way * (yaw + turn / 2.0).sin();
        yaw += turn;
    }
    recording("angles", columns)
}

fn diagnosed(lag_s: f64, rounding_rad: f64) -> Answer {
    answer_to(recorded(lag_s, rounding_rad))
}

fn answer_to(recording: Recording) -> Answer {
    let request = Request {
        recordings: &[recording],
        against: &[],
        model_of: &|_| Some(slipstream_testkit::kinematic(RADIUS_M, HALF_TRACK_M)),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    };
    diagnose(&request).unwrap().0
}

#[test]
fn a_lag_is_found_whatever_the_steps_of_the_wheel_angles() {
    // exact, as a simulator tells them; 16 bits; finer and coarser than 1.5 mrad; 1024 counts
    for rounding_rad in [0.0, 1e-4, 1.4e-3, 1.6e-3, 6.1e-3] {
        let answer = diagnosed(LAG_S, rounding_rad);
        let findings: Vec<_> = answer.findings.iter().map(|f| f.effect.as_str()).collect();
        assert_eq!(findings, ["actuator_lag"], "{rounding_rad}");
        let found = answer.findings[0].parameters[0].estimate.unwrap();
        // a step of the angle at 5 rad/s is about a millisecond
        assert!((found - LAG_S).abs() < 1e-3, "{rounding_rad}: {found}");
    }
}

#[test]
fn a_drive_without_a_lag_matches_with_exact_angles() {
    let answer = diagnosed(0.0, 0.0);
    assert_eq!(answer.verdict, Verdict::Match, "{:?}", answer.findings);
}

#[test]
fn encoders_that_count_by_a_wrong_factor_are_a_finding_with_its_cause() {
    // quadrature; degrees and turns instead of radians
    for (counts, cause) in [
        (4.0, "quadrature x4"),
        (180.0 / std::f64::consts::PI, "degrees instead of radians"),
        (0.5 / std::f64::consts::PI, "turns instead of radians"),
    ] {
        let mut recording = recorded(0.0, 0.0);
        let wheels = recording.robots[0].wheels.as_mut().unwrap();
        if let Wheels::Angle {
            right_rad,
            left_rad,
        } = &mut wheels.values
        {
            let both = right_rad.iter_mut().chain(left_rad);
            both.for_each(|angle| *angle *= counts);
        }
        let mut alone = recording.clone();
        alone.robots[0].command = None;
        for recording in [recording, alone] {
            let answer = answer_to(recording);
            let findings: Vec<_> = answer.findings.iter().map(|f| f.effect.as_str()).collect();
            assert_eq!(findings, ["encoder_scale"], "{counts}");
            let finding = &answer.findings[0];
            for parameter in &finding.parameters {
                let scale = parameter.estimate.unwrap() / counts;
                assert!((scale - 1.0).abs() < 1e-3, "{counts}: {scale}");
            }
            assert!(finding.statement.contains(cause), "{}", finding.statement);
            assert!(finding.actions[0].contains(cause), "{:?}", finding.actions);
        }
    }
}
