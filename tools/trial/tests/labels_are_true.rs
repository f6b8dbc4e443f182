//! Labels are true: `sim` with the labelled effect reproduces the recording up to noise, and without it
//! does not.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use slipstream_bus::{EffectSpec, RobotModel};
use slipstream_recording::recording::{Robot, Wheels};
use slipstream_recording::{Recording, compare};
use slipstream_trial::maker::{
    Camera, CommandKind, Control, Recorded, Scene, Start, Style, TrueRobot, make,
};

const TICK_RAD: f64 = std::f64::consts::TAU / 1856.0;

fn scene(concealed: Option<EffectSpec>, command_kind: CommandKind, style: Style) -> Scene {
    Scene {
        kind: String::new(),
        nominal: RobotModel::default(),
        robots: vec![TrueRobot {
            concealed: concealed.into_iter().collect(),
            outside: None,
            camera: Camera::Pose,
        }],
        control: Control::Open,
        command_kind,
        style,
        duration_s: 8.0,
        imu: true,
        disturbance_n: 0.0,
        noise: None,
        recorded: Recorded::default(),
        start: Start::Rest,
        step_s: 1e-4,
        without: Vec::new(),
        seed: 7,
    }
}

/// The largest residual of a channel, in standard deviations of its noise.
fn largest_residual(recording: &Recording, model: &RobotModel) -> f64 {
    let channels = compare(recording, |_| Some(model.clone())).unwrap();
    let deviation = |name: &str| match name {
        // 2 mm of noise, and the error of the heading that the comparison fits to half a second of it.
        "pose x" | "pose y" => 0.008,
        "pose yaw" => 0.0087,
        "imu gz" => 0.006,
        "imu ax" | "imu ay" => 0.06,
        _ => TICK_RAD / 12f64.sqrt(),
    };
    let judged = channels.iter().map(|channel| {
        let found = channel.rms_difference().unwrap_or(f64::NAN) / deviation(&channel.name);
        println!("    {} {found:.2}", channel.name);
        found
    });
    judged.fold(0.0, f64::max)
}

#[test]
fn sim_with_the_label_reproduces_the_recording() {
    let effects: &[(&str, &[(&str, f64)])] = &[
        ("rolling_resistance", &[("coefficient", 0.01)]),
        (
            "wheel_slip",
            &[("friction_static", 0.22), ("friction_kinetic", 0.215)],
        ),
        (
            "payload",
            &[("mass_kg", 0.3), ("x_m", 0.02), ("y_m", -0.03)],
        ),
        ("backlash", &[("gap_rad", 0.05)]),
        ("yaw_scrub", &[("moment_nm", 0.02)]),
    ];
    for (id, parameters) in effects {
        let concealed = EffectSpec::new(id, parameters);
        let made = make(
            &scene(Some(concealed), CommandKind::Torque, Style::Wild),
            "case",
        )
        .unwrap();
        assert_eq!(made.label.effects[0].effect, *id);
        let truth = made.model.clone().with(id, parameters);
        println!("{id}");
        let (with, without) = (
            largest_residual(&made.recording, &truth),
            largest_residual(&made.recording, &made.model),
        );
        assert!(
            with < 1.6,
            "{id}: a residual of {with:.2} standard deviations"
        );
        assert!(
            without > 1.5 * with,
            "{id}: {without:.2} without it, {with:.2} with it"
        );
        let gain = made.label.effects[0].expected_gain.unwrap();
        assert!(gain > 100.0, "{id}: {gain} nats");
    }
}

/// One robot's measurements with an effect of its sensors, which does not change the motion.
fn measured(concealed: Option<EffectSpec>) -> Robot {
    let made = make(
        &scene(concealed, CommandKind::Torque, Style::Lively),
        "case",
    )
    .unwrap();
    made.recording.robots.into_iter().next().unwrap()
}

#[test]
fn a_latency_shifts_the_time_stamps() {
    let plain = measured(None);
    let late = |id: &str| measured(Some(EffectSpec::new(id, &[("latency_s", 0.03)])));
    let moved = |from: &[f64], to: &[f64]| {
        from.iter()
            .zip(to)
            .map(|(from, to)| (to - from - 0.03).abs())
            .fold(0.0, f64::max)
    };
    let times = |robot: &Robot| {
        let (pose, wheels, imu) = (
            robot.pose.as_ref(),
            robot.wheels.as_ref(),
            robot.imu.as_ref(),
        );
        [&pose.unwrap().t_s, &wheels.unwrap().t_s, &imu.unwrap().t_s].map(Clone::clone)
    };
    for (at, id) in ["pose_latency", "wheels_latency", "imu_latency"]
        .into_iter()
        .enumerate()
    {
        assert!(
            moved(&times(&plain)[at], &times(&late(id))[at]) < 2e-6,
            "{id}"
        );
    }
}

#[test]
fn scales_and_offsets_have_the_labelled_size() {
    let plain = measured(None);
    let scale = EffectSpec::new(
        "encoder_scale",
        &[("right_scale", 1.01), ("left_scale", 0.98)],
    );
    let ticks = |robot: &Robot| match &robot.wheels.as_ref().unwrap().values {
        Wheels::Ticks { right, left } => [right, left].map(|wheel| wheel.last().unwrap().unwrap()),
        _ => panic!("ticks were asked for"),
    };
    let ([right, left], [more, less]) = (ticks(&plain), ticks(&measured(Some(scale))));
    assert!(
        (more as f64 - 1.01 * right as f64).abs() < 2.0,
        "{more} of {right}"
    );
    assert!(
        (less as f64 - 0.98 * left as f64).abs() < 2.0,
        "{less} of {left}"
    );
    let offset = EffectSpec::new(
        "pose_offset",
        &[("x_m", 0.03), ("y_m", -0.02), ("yaw_rad", 0.05)],
    );
    let other = measured(Some(offset)).pose.unwrap().values;
    let pose = plain.pose.unwrap().values;
    let yaws = pose
        .yaw_rad
        .unwrap()
        .into_iter()
        .zip(other.yaw_rad.unwrap());
    for (at, (yaw, turned)) in yaws.enumerate() {
        // The noise is the same, but that of the yaw also turns the offset.
        let (sin, cos) = yaw.sin_cos();
        let away = [other.x_m[at] - pose.x_m[at], other.y_m[at] - pose.y_m[at]];
        assert!((away[0] - 0.03 * cos - 0.02 * sin).abs() < 2e-3);
        assert!((away[1] - 0.03 * sin + 0.02 * cos).abs() < 2e-3);
        let turns = (turned - yaw - 0.05) / std::f64::consts::TAU;
        assert!((turns - turns.round()).abs() < 1e-5);
    }
}

#[test]
fn a_case_without_effects_leaves_only_noise() {
    for command_kind in [
        CommandKind::Torque,
        CommandKind::Voltage,
        CommandKind::Twist,
        CommandKind::WheelSpeed,
    ] {
        let scene = Scene {
            imu: false,
            ..scene(None, command_kind, Style::Lively)
        };
        let made = make(&scene, "case").unwrap();
        println!("{command_kind:?}");
        assert!(
            largest_residual(&made.recording, &made.model) < 1.4,
            "{command_kind:?}"
        );
    }
}

#[test]
fn the_same_seed_gives_the_same_case() {
    let made = || make(&scene(None, CommandKind::Torque, Style::Cruise), "case").unwrap();
    let text = |made: &slipstream_trial::maker::MadeCase| format!("{:?}", made.recording);
    assert_eq!(text(&made()), text(&made()));
}
