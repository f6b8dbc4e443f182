//! `compare` on recordings of the simulated plant: the same model gives the same motion.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{Command, Pose, Recording, Robot, Stream, Wheels};
use slipstream_recording::{CompareError, compare};
use slipstream_sim::{Command as PlantCommand, Robot as Plant};

fn stream<V>(t_s: &[f64], values: V) -> Stream<V> {
    Stream {
        t_s: t_s.to_vec(),
        values,
        unknown: Vec::new(),
    }
}

/// Ten seconds of torque commands, starting away from the origin.
fn drive(model: &RobotModel) -> Recording {
    let plant = Plant::new(model).unwrap();
    let mut state = plant.start([1.0, -2.0, 0.5]);
    let mut columns: [Vec<f64>; 8] = Default::default();
    for i in 0..500 {
        let t_s = 3.0 + f64::from(i) * 0.02;
        let [x, y, yaw] = state.pose();
        let [right, left] = state.wheel_angle();
        let torque = [0.03 * (0.7 * t_s).sin(), 0.03 * (0.9 * t_s).sin()];
        let row = [
            t_s,
            x,
            y,
            yaw,
            right + 12.0,
            left - 7.0,
            torque[0],
            torque[1],
        ];
        for (column, value) in columns.iter_mut().zip(row) {
            column.push(value);
        }
        for k in 0..20 {
            let command = PlantCommand::Torque {
                right_nm: torque[0],
                left_nm: torque[1],
            };
            plant.step(&mut state, t_s - 3.0 + f64::from(k) * 1e-3, 1e-3, &command);
        }
    }
    let [
        t_s,
        x_m,
        y_m,
        yaw_rad,
        right_rad,
        left_rad,
        right_nm,
        left_nm,
    ] = columns;
    let mut robot = Robot::named("r1");
    robot.command = Some(stream(&t_s, Command::Torque { right_nm, left_nm }));
    robot.wheels = Some(stream(
        &t_s,
        Wheels::Angle {
            right_rad,
            left_rad,
        },
    ));
    let yaw_rad = Some(yaw_rad);
    robot.pose = Some(stream(&t_s, Pose { x_m, y_m, yaw_rad }));
    Recording {
        robots: vec![robot],
        ..Recording::default()
    }
}

#[test]
fn the_same_model_reproduces_the_recording_and_another_does_not() {
    let model = RobotModel::paper_with_slip();
    let recording = drive(&model);
    let channels = compare(&recording, |_| Some(model.clone())).unwrap();
    let names: Vec<&str> = channels
        .iter()
        .map(|channel| channel.name.as_str())
        .collect();
    assert_eq!(
        names,
        ["pose x", "pose y", "pose yaw", "wheel right", "wheel left"]
    );
    for channel in &channels {
        // The rest is the error of interpolating between samples 5 ms apart, here below 0.1 mm.
        let rms = channel.rms_difference().unwrap();
        assert!(rms < 1e-4, "{}: {rms}", channel.name);
    }
    let mut heavier = model.clone();
    heavier.robot.body_mass_kg = Some(2.5);
    let channels = compare(&recording, |_| Some(heavier.clone())).unwrap();
    assert!(channels[0].rms_difference().unwrap() > 0.05);
}

#[test]
fn without_commands_the_wheels_drive_the_simulation() {
    let mut model = RobotModel::paper_with_slip();
    model.effects.clear();
    let mut recording = drive(&model);
    recording.robots[0].command = None;
    let channels = compare(&recording, |_| Some(model.clone())).unwrap();
    let worst = channels
        .iter()
        .filter_map(|channel| channel.rms_difference())
        .fold(0.0, f64::max);
    assert!(worst < 0.02, "{worst}");
}

#[test]
fn what_cannot_be_simulated_is_an_error() {
    let model = RobotModel::default();
    let mut recording = drive(&model);
    let error = compare(&recording, |_| None).unwrap_err();
    assert_eq!(error, CompareError::NoModel("r1".to_owned()));
    let mut massless = model.clone();
    massless.robot.body_mass_kg = None;
    let error = compare(&recording, |_| Some(massless.clone())).unwrap_err();
    assert!(matches!(error, CompareError::Model { .. }), "{error}");
    recording.robots[0].command = None;
    recording.robots[0].wheels = None;
    let error = compare(&recording, |_| Some(model.clone())).unwrap_err();
    assert_eq!(error, CompareError::NothingToSimulate);
}
