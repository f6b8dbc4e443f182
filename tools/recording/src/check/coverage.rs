//! Coverage: what a recording can be used for, and what is missing.

use slipstream_bus::RobotModel;

use crate::recording::{Command, Recording, Robot, Wheels};

/// What the recording can be used for, and what is missing, as sentences.
pub(super) fn coverage(
    recording: &Recording,
    model: Option<&RobotModel>,
) -> (Vec<String>, Vec<String>) {
    let (mut can_judge, mut missing) = (Vec::new(), Vec::new());
    for robot in &recording.robots {
        for (sentences, list) in [
            (uses(robot), &mut can_judge),
            (gaps(robot, model), &mut missing),
        ] {
            list.extend(
                sentences
                    .into_iter()
                    .map(|what| format!("{}: {what}", robot.name)),
            );
        }
    }
    if recording.links.is_some() {
        can_judge.push("links: delay and loss of the messages between robots".to_owned());
    }
    if recording.rtt.is_some() {
        can_judge.push("rtt: replay as link delay (links.trace)".to_owned());
    }
    if model.is_none() && !recording.robots.is_empty() {
        missing.push(
            "a robot model (--robot): without it no factors between wheels and pose".to_owned(),
        );
    }
    (can_judge, missing)
}

/// What the streams of a robot can be used for.
fn uses(robot: &Robot) -> Vec<String> {
    let commands_force = robot
        .command
        .as_ref()
        .is_some_and(|s| matches!(s.values, Command::Torque { .. } | Command::Voltage { .. }));
    let commands_speed = robot.command.is_some() && !commands_force;
    let (wheels, pose) = (robot.wheels.is_some(), robot.pose.is_some());
    let gyro = robot
        .imu
        .as_ref()
        .is_some_and(|imu| imu.values.gz_rad_s.is_some());
    let has_motion = wheels || pose || gyro || robot.odometry.is_some();
    let rules: [(bool, &str); 7] = [
        (
            commands_force && has_motion,
            "forces and drive train: friction, drag, motor, payload, slope",
        ),
        (
            commands_speed && has_motion,
            "how the drives follow their commands: lag, delay, gain, limits",
        ),
        (
            wheels && pose,
            "wheels against floor: slip, wheel radius, track width, sensor offsets",
        ),
        (
            wheels && gyro && !pose,
            "turning against the gyro: slip in turns, track width",
        ),
        (
            pose && !wheels && robot.command.is_some(),
            "motion against the command, wheels unseen",
        ),
        (
            wheels && robot.imu.is_some(),
            "latency between wheels and IMU",
        ),
        (pose && gyro, "latency between pose and gyro"),
    ];
    rules
        .iter()
        .filter(|(holds, _)| *holds)
        .map(|(_, what)| (*what).to_owned())
        .collect()
}

/// What a robot lacks.
fn gaps(robot: &Robot, model: Option<&RobotModel>) -> Vec<String> {
    let has_ticks = robot
        .wheels
        .as_ref()
        .is_some_and(|s| matches!(s.values, Wheels::Ticks { .. }));
    let has_counts = robot.counts_per_rev(model).is_some();
    let has_yaw = robot
        .pose
        .as_ref()
        .is_none_or(|pose| pose.values.yaw_rad.is_some());
    let noise_unknown = robot.pose.is_some() && robot.noise.pose_m.is_none();
    let rules: [(bool, &str); 6] = [
        (
            robot.command.is_none(),
            "command.csv: what the drives were told; without it no drive-train effect",
        ),
        (
            robot.wheels.is_none(),
            "wheels.csv: without it slip and drive train cannot be told apart",
        ),
        (
            robot.pose.is_none(),
            "pose.csv: without it nothing about the floor but through a gyro",
        ),
        (
            !has_yaw,
            "yaw_rad in pose.csv: sideways motion cannot be told from turning",
        ),
        (
            has_ticks && !has_counts,
            "encoder_counts_per_rev: ticks cannot be turned into angles",
        ),
        (
            noise_unknown,
            "noise.pose_m in recording.toml: it will be estimated",
        ),
    ];
    rules
        .iter()
        .filter(|(holds, _)| *holds)
        .map(|(_, what)| (*what).to_owned())
        .collect()
}
