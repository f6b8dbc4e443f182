//! What several tests share.

use slipstream_answer::Answer;
use slipstream_bus::{InputError, RobotModel};
use slipstream_diagnose::{Request, diagnose};
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command, Pose, Robot, Stream, Wheels};

/// What is found of a recording of one robot with this model, and the model with it.
pub(crate) fn diagnosed(
    recording: Recording,
    nominal: &RobotModel,
) -> Result<(Answer, RobotModel), InputError> {
    let request = Request {
        recordings: &[recording],
        against: &[],
        model_of: &|_| Some(nominal.clone()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    };
    let (answer, mut improved) = diagnose(&request)?;
    Ok((answer, improved.remove(0).1))
}

/// Noise between -1 and 1 without a pattern, the same for the same `k`.
pub(crate) fn noise(k: f64) -> f64 {
    2.0 * ((k * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0) - 1.0
}

/// The recording of one robot `r1` with these columns: time, right and left of commanded speeds (rad/s), the same of
/// wheel angles (rad); time, x, y (m) and yaw (rad) of poses.
pub(crate) fn recording(name: &str, columns: [Vec<f64>; 10]) -> Recording {
    let [
        told_s,
        right_rad_s,
        left_rad_s,
        wheels_s,
        right_rad,
        left_rad,
        seen_s,
        x_m,
        y_m,
        yaw,
    ] = columns;
    let mut robot = Robot::named("r1");
    robot.command = Some(Stream {
        t_s: told_s,
        values: Command::WheelSpeed {
            right_rad_s,
            left_rad_s,
        },
        unknown: vec![],
    });
    robot.wheels = Some(Stream {
        t_s: wheels_s,
        values: Wheels::Angle {
            right_rad,
            left_rad,
        },
        unknown: vec![],
    });
    robot.pose = Some(Stream {
        t_s: seen_s,
        values: Pose {
            x_m,
            y_m,
            yaw_rad: Some(yaw),
        },
        unknown: vec![],
    });
    Recording {
        name: name.to_owned(),
        robots: vec![robot],
        ..Recording::default()
    }
}
