//! Recordings that hold less than they seem to: what can be said is said, and no verdict is confident without reason.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on says so and stops"
)]

mod common;
mod drive;

use slipstream_answer::{Answer, Verdict};
use slipstream_bus::InputError;
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command, Pose, Wheels};

use drive::{HALF_TRACK_M, RADIUS_M};

const LAG_S: f64 = 0.1;
/// A row of poses is 50 ms behind the last one; this is half-way.
const HALF_WAY: usize = 300;

fn recorded() -> Recording {
    drive::recorded(1, LAG_S, 1.4e-3)
}

fn poses(recording: &mut Recording) -> &mut Pose {
    &mut recording.robots[0].pose.as_mut().unwrap().values
}

fn answer_to(recording: Recording) -> Result<Answer, InputError> {
    let nominal = slipstream_testkit::kinematic(RADIUS_M, HALF_TRACK_M);
    common::diagnosed(recording, &nominal).map(|(answer, _)| answer)
}

/// The lag is found and explains the recording, and a warning with this id says what is wrong.
fn finds_the_lag(recording: Recording, warning: &str) {
    let answer = answer_to(recording).unwrap();
    let findings: Vec<_> = answer.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(findings, ["actuator_lag"], "{warning}");
    let found = answer.findings[0].parameters[0].estimate.unwrap();
    assert!((found - LAG_S).abs() < 2e-3, "{warning}: {found}");
    assert_eq!(answer.verdict, Verdict::Explained, "{}", answer.statement);
    let said: Vec<_> = answer.warnings.iter().map(|own| own.id.as_str()).collect();
    assert!(said.contains(&warning), "{said:?}");
}

#[test]
fn wheels_and_poses_of_two_robots_are_not_explained() {
    let mut both = recorded();
    // the same speeds in another order
    both.robots[0].pose = drive::recorded(2, LAG_S, 0.0).robots.remove(0).pose;
    let answer = answer_to(both).unwrap();
    assert_eq!(answer.verdict, Verdict::Unexplained, "{}", answer.statement);
    let says = answer.statement.contains("of the way that the robot goes");
    assert!(says, "{}", answer.statement);
}

#[test]
fn a_command_that_the_wheels_do_not_follow_is_not_explained() {
    let mut recording = recorded();
    let command = &mut recording.robots[0].command.as_mut().unwrap().values;
    if let Command::WheelSpeed { right_rad_s, .. } = command {
        right_rad_s.fill(4.0);
    }
    let answer = answer_to(recording).unwrap();
    assert_eq!(answer.verdict, Verdict::Unexplained, "{}", answer.statement);
}

#[test]
fn five_seconds_leave_nothing_to_test_on() {
    let mut recording = recorded();
    let robot = &mut recording.robots[0];
    let is_kept = |t_s: &f64| *t_s < 5.0;
    let rows = |t_s: &[f64]| t_s.iter().filter(|t_s| is_kept(t_s)).count();
    let command = robot.command.as_mut().unwrap();
    let wheels = robot.wheels.as_mut().unwrap();
    let pose = robot.pose.as_mut().unwrap();
    let kept = [rows(&command.t_s), rows(&wheels.t_s), rows(&pose.t_s)];
    let streams = [&mut command.t_s, &mut wheels.t_s, &mut pose.t_s];
    streams
        .into_iter()
        .zip(kept)
        .for_each(|(t_s, len)| t_s.truncate(len));
    if let Command::WheelSpeed {
        right_rad_s,
        left_rad_s,
    } = &mut command.values
    {
        for column in [right_rad_s, left_rad_s] {
            column.truncate(kept[0]);
        }
    }
    if let Wheels::Angle {
        right_rad,
        left_rad,
    } = &mut wheels.values
    {
        for column in [right_rad, left_rad] {
            column.truncate(kept[1]);
        }
    }
    let Pose { x_m, y_m, yaw_rad } = &mut pose.values;
    for column in [x_m, y_m, yaw_rad.as_mut().unwrap()] {
        column.truncate(kept[2]);
    }
    let answer = answer_to(recording).unwrap();
    assert_eq!(answer.verdict, Verdict::Unexplained);
    assert!(
        answer.statement.starts_with("Not tested"),
        "{}",
        answer.statement
    );
    assert!(answer.warnings.iter().any(|own| own.id == "short"));
}

#[test]
fn a_reference_that_is_lost_half_way_tells_what_it_saw() {
    let mut recording = recorded();
    let Pose { x_m, y_m, yaw_rad } = poses(&mut recording);
    for column in [x_m, y_m, yaw_rad.as_mut().unwrap()] {
        let last = column[HALF_WAY];
        column[HALF_WAY..].fill(last);
    }
    finds_the_lag(recording, "reference_lost");
}

#[test]
fn a_pose_that_jumps_spoils_nothing() {
    let mut recording = recorded();
    let pose = poses(&mut recording);
    pose.x_m[HALF_WAY..].iter_mut().for_each(|x_m| *x_m += 2.0);
    pose.y_m[HALF_WAY..].iter_mut().for_each(|y_m| *y_m -= 1.0);
    finds_the_lag(recording, "pose_jumps");
}

#[test]
fn a_heading_that_never_changes_is_not_read() {
    let mut recording = recorded();
    poses(&mut recording).yaw_rad.as_mut().unwrap().fill(0.0);
    finds_the_lag(recording, "heading_never_changes");
}

#[test]
fn what_never_changes_is_refused_in_words() {
    let mut recording = recorded();
    poses(&mut recording).x_m.fill(1.0);
    let refusal = answer_to(recording).unwrap_err().to_string();
    assert!(refusal.contains("x of the pose never changes"), "{refusal}");

    let mut recording = recorded();
    if let Wheels::Angle { left_rad, .. } = &mut recording.robots[0].wheels.as_mut().unwrap().values
    {
        left_rad.fill(0.7);
    }
    let refusal = answer_to(recording).unwrap_err().to_string();
    assert!(refusal.contains("left wheel never changes"), "{refusal}");
}
