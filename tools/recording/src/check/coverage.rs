//! Coverage: what a recording can be used for, and what is missing.

use slipstream_bus::RobotModel;

use crate::rows::{AllRows, RobotRows};
use crate::table::StreamKind;

/// What the recording can be used for, and what is missing, as sentences.
pub(super) fn coverage(
    rows: &AllRows<'_>,
    model: Option<&RobotModel>,
) -> (Vec<String>, Vec<String>) {
    let (mut can_judge, mut missing) = (Vec::new(), Vec::new());
    for robot in &rows.robots {
        for (sentences, list) in [
            (uses(robot), &mut can_judge),
            (gaps(robot, model), &mut missing),
        ] {
            list.extend(
                sentences
                    .into_iter()
                    .map(|what| format!("{}: {what}", robot.robot.name)),
            );
        }
    }
    if rows.links.is_some() {
        can_judge.push("links: delay and loss of the messages between robots".to_owned());
    }
    if rows.rtt.is_some() {
        can_judge.push("rtt: replay as link delay (links.trace)".to_owned());
    }
    if model.is_none() && !rows.robots.is_empty() {
        missing.push(
            "a robot model (--robot): without it no factors between wheels and pose".to_owned(),
        );
    }
    (can_judge, missing)
}

/// What the streams of a robot can be used for.
fn uses(robot: &RobotRows<'_>) -> Vec<String> {
    let has = |kind| robot.stream(kind).is_some();
    let forces = ["torque_right_nm", "voltage_right_v"];
    let commands_force = robot.has_any(StreamKind::Command, &forces);
    let commands_speed = has(StreamKind::Command) && !commands_force;
    let (wheels, pose) = (has(StreamKind::Wheels), has(StreamKind::Pose));
    let gyro = robot.has_any(StreamKind::Imu, &["gz_rad_s"]);
    let has_motion = wheels || pose || gyro || has(StreamKind::Odometry);
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
            pose && !wheels && has(StreamKind::Command),
            "motion against the command, wheels unseen",
        ),
        (
            wheels && has(StreamKind::Imu),
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
fn gaps(robot: &RobotRows<'_>, model: Option<&RobotModel>) -> Vec<String> {
    let has = |kind| robot.stream(kind).is_some();
    let has_ticks = robot.has_any(StreamKind::Wheels, &["ticks_right"]);
    let has_counts = robot.robot.counts_per_rev(model).is_some();
    let has_yaw = !has(StreamKind::Pose) || robot.has_any(StreamKind::Pose, &["yaw_rad"]);
    let noise_unknown = has(StreamKind::Pose) && robot.robot.noise.pose_m.is_none();
    let rules: [(bool, &str); 6] = [
        (
            !has(StreamKind::Command),
            "command.csv: what the drives were told; without it no drive-train effect",
        ),
        (
            !has(StreamKind::Wheels),
            "wheels.csv: without it slip and drive train cannot be told apart",
        ),
        (
            !has(StreamKind::Pose),
            "pose.csv: without it nothing about the floor but through a gyro",
        ),
        (
            !has_yaw,
            "yaw_rad in pose.csv: sideways motion cannot be told from turning",
        ),
        (
            has_ticks && !has_counts,
            "encoder_counts_per_rev, in recording.toml or in the map for --topics or --columns; or counts_per_rev under [encoder] in \
             robot.toml: ticks cannot be turned into angles",
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
