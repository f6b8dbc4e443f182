//! What can be judged from a recording, and what is missing.

use slipstream_bus::RobotModel;

use crate::recording::{Command, Recording, Robot, Wheels};

/// What can be judged, and what is missing.
pub(super) fn of(recording: &Recording, model: Option<&RobotModel>) -> (Vec<String>, Vec<String>) {
    let (mut can, mut missing) = (Vec::new(), Vec::new());
    for robot in &recording.robots {
        for (found, list) in [
            (judged(robot), &mut can),
            (lacking(robot, model), &mut missing),
        ] {
            list.extend(
                found
                    .into_iter()
                    .map(|what| format!("{}: {what}", robot.name)),
            );
        }
    }
    if recording.links.is_some() {
        can.push("links: delay and loss of the messages between robots".to_owned());
    }
    if recording.rtt.is_some() {
        can.push("rtt: replay as link delay (links.trace)".to_owned());
    }
    if model.is_none() && !recording.robots.is_empty() {
        missing.push(
            "a robot model (--robot): without it no factors between wheels and pose".to_owned(),
        );
    }
    (can, missing)
}

fn judged(robot: &Robot) -> Vec<String> {
    let force = robot
        .command
        .as_ref()
        .is_some_and(|s| matches!(s.values, Command::Torque { .. } | Command::Voltage { .. }));
    let speed = robot.command.is_some() && !force;
    let (wheels, pose) = (robot.wheels.is_some(), robot.pose.is_some());
    let gyro = robot
        .imu
        .as_ref()
        .is_some_and(|imu| imu.values.gz_rad_s.is_some());
    let moves = wheels || pose || gyro || robot.odometry.is_some();
    let rules: [(bool, &str); 7] = [
        (
            force && moves,
            "forces and drive train: friction, drag, motor, payload, slope",
        ),
        (
            speed && moves,
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

fn lacking(robot: &Robot, model: Option<&RobotModel>) -> Vec<String> {
    let ticks = robot
        .wheels
        .as_ref()
        .is_some_and(|s| matches!(s.values, Wheels::Ticks { .. }));
    let counts = robot.encoder_counts_per_rev.is_some()
        || model.is_some_and(|model| model.encoder.is_some());
    let yaw = robot
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
            !yaw,
            "yaw_rad in pose.csv: sideways motion cannot be told from turning",
        ),
        (
            ticks && !counts,
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
