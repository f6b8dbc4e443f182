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
mod drive;

use slipstream_answer::{Answer, Verdict};
use slipstream_recording::Recording;
use slipstream_recording::recording::Wheels;

use drive::{HALF_TRACK_M, RADIUS_M, recorded};

const LAG_S: f64 = 0.1;

fn diagnosed(lag_s: f64, rounding_rad: f64) -> Answer {
    answer_to(recorded(1, lag_s, rounding_rad))
}

fn answer_to(recording: Recording) -> Answer {
    let nominal = slipstream_testkit::kinematic(RADIUS_M, HALF_TRACK_M);
    common::diagnosed(recording, &nominal).unwrap().0
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
        let mut recording = recorded(1, 0.0, 0.0);
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
