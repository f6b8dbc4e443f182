//! What the tests of several modules begin from: tracks without noise, made by the plant itself.

use slipstream_bus::RobotModel;
use slipstream_sim::{Command, Robot, State};

use crate::data::track::{Driver, Sensor, Series, Track};
use crate::predict::predictor::Predictor;
use crate::predict::window::{LOCALS, WINDOW_S, Window, cut};

/// How long each command holds, and between two rows of every sensor (s).
pub(crate) const HOLD_S: f64 = 0.02;

pub(crate) fn series(sensor: Sensor, rows: Vec<(f64, [f64; 3])>, deviation: f64) -> Series {
    Series {
        sensor,
        rows,
        deviation: [deviation; 3],
        is_guessed: false,
    }
}

pub(crate) fn track(commands: Vec<(f64, Command)>, series: Vec<Series>) -> Track {
    Track {
        recording: "made".to_owned(),
        robot: "r1".to_owned(),
        driver: Driver::Command,
        commands,
        series,
        left_out_s: Vec::new(),
        tracked_ahead_m: 0.0,
        imu_without_weight: false,
    }
}

/// `length_s` of `model` under `torque` (N m, right and left, at a time in s), wheel angles and poses
/// as they are.
pub(crate) fn driven(model: &RobotModel, length_s: f64, torque: fn(f64) -> [f64; 2]) -> Track {
    let robot: Robot = Robot::new(model).unwrap();
    let mut state: State = robot.start([0.0; 3]);
    let (mut commands, mut angles, mut poses) = (vec![], vec![], vec![]);
    for k in 0..(length_s / HOLD_S).round() as u32 {
        let t_s = f64::from(k) * HOLD_S;
        let [right_nm, left_nm] = torque(t_s);
        let command = Command::Torque { right_nm, left_nm };
        let [right, left] = robot.measured_angle(&state);
        angles.push((t_s, [right, left, f64::NAN]));
        poses.push((t_s, state.pose()));
        commands.push((t_s, command));
        for step in 0..20 {
            robot.step(&mut state, t_s + f64::from(step) * 1e-3, 1e-3, &command);
        }
    }
    let angles = series(Sensor::WheelAngle, angles, 1e-3);
    track(commands, vec![angles, series(Sensor::Pose, poses, 2e-3)])
}

/// Torques (N m) under which both wheels turn to and fro and do not slip.
pub(crate) fn gentle(t_s: f64) -> [f64; 2] {
    [
        0.04 * (1.9 * t_s).sin() + 0.01,
        0.04 * (1.9 * t_s + 0.3).sin() + 0.01,
    ]
}

pub(crate) fn predictor(track: Track, model: RobotModel) -> Predictor {
    let windows = cut(&track, 0, WINDOW_S);
    Predictor {
        tracks: vec![track],
        windows,
        model,
    }
}

/// Rows of these channels in a window, of nothing.
pub(crate) fn window(channels: Vec<u8>) -> Window {
    Window {
        run: 0,
        from_s: 0.0,
        to_s: 1.0,
        command: 0,
        rows: Vec::new(),
        base: Vec::new(),
        stamps_s: vec![0.0; channels.len()],
        channels,
        free: [true; LOCALS],
        rests: Vec::new(),
    }
}
