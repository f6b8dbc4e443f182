//! Recordings whose truth is known, made by the plant at another step than the fit's.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on says so and stops"
)]

use slipstream_bus::{Camera, RobotModel, Sensors};
use slipstream_diagnose::{Answer, Request, Verdict, diagnose};
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command as Told, Pose, Robot, Stream, Wheels};
use slipstream_sim::{Command, Setup, World};

fn torque(t_s: f64) -> [f64; 2] {
    let t = (t_s / 0.02).floor() * 0.02;
    [
        0.04 * (0.9 * t).sin() + 0.02 * (3.1 * t).sin(),
        0.04 * (0.9 * t + 0.3).sin(),
    ]
}

/// 12 s of a robot that really is `model`, with encoders and an overhead camera.
fn record(model: &RobotModel, seed: u64) -> Recording {
    let sensors = Sensors {
        camera: Some(Camera::default()),
        imu: None,
    };
    let setup = Setup {
        name: "r1".to_owned(),
        model: model.clone(),
        pose: [0.0; 3],
        sensors,
    };
    let mut world = World::new(&[setup], seed).unwrap();
    let (mut command, mut wheels) = ([vec![], vec![], vec![]], (vec![], vec![], vec![]));
    let mut pose = Stream {
        t_s: vec![],
        values: Pose::default(),
        unknown: vec![],
    };
    let mut yaw = vec![];
    for k in 0..24_000 {
        let t_s = f64::from(k) * 5e-4;
        let [right_nm, left_nm] = torque(t_s + 1e-6);
        if k % 40 == 0 {
            command[0].push(t_s);
            command[1].push(right_nm);
            command[2].push(left_nm);
            let [right, left] = world.encoder_counts(0);
            wheels.0.push(t_s);
            wheels.1.push(Some(right));
            wheels.2.push(Some(left));
        }
        world.step(500_000, &[Command::Torque { right_nm, left_nm }]);
        if let Some(frame) = world.camera(0) {
            pose.t_s.push(frame.stamp_ns as f64 * 1e-9);
            pose.values.x_m.push(frame.value[0]);
            pose.values.y_m.push(frame.value[1]);
            yaw.push(frame.value[2]);
        }
    }
    pose.values.yaw_rad = Some(yaw);
    let [t_s, right_nm, left_nm] = command;
    let mut robot = Robot::named("r1");
    robot.encoder_counts_per_rev = Some(1856);
    robot.noise.pose_m = Some(0.002);
    robot.noise.pose_rad = Some(0.009);
    robot.command = Some(Stream {
        t_s,
        values: Told::Torque { right_nm, left_nm },
        unknown: vec![],
    });
    let values = Wheels::Ticks {
        right: wheels.1,
        left: wheels.2,
    };
    robot.wheels = Some(Stream {
        t_s: wheels.0,
        values,
        unknown: vec![],
    });
    robot.pose = Some(pose);
    Recording {
        name: "truth".to_owned(),
        robots: vec![robot],
        ..Recording::default()
    }
}

fn answer(truth: &RobotModel, nominal: &RobotModel, seed: u64) -> (Answer, RobotModel) {
    let (answer, mut improved) = diagnose(&Request {
        recordings: &[record(truth, seed)],
        model_of: &|_| Some(nominal.clone()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    })
    .unwrap();
    (answer, improved.remove(0).1)
}

#[test]
fn a_model_that_is_right_matches() {
    let model = RobotModel::default();
    let (answer, _) = answer(&model, &model, 1);
    assert_eq!(
        answer.verdict,
        Verdict::Match,
        "{}",
        serde_json::to_string(&answer).unwrap()
    );
}

#[test]
fn what_is_left_out_is_named_and_measured_and_then_matches() {
    let nominal = RobotModel::default();
    let truth = nominal
        .clone()
        .with("rolling_resistance", &[("coefficient", 0.008)]);
    let (first, improved) = answer(&truth, &nominal, 2);
    let text = serde_json::to_string(&first).unwrap();
    assert_eq!(first.verdict, Verdict::Explained, "{text}");
    let found: Vec<&str> = first.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(found, ["rolling_resistance"], "{text}");
    let estimate = first.findings[0].parameters[0].estimate.unwrap();
    assert!((estimate - 0.008).abs() < 0.05 * 0.008, "{text}");
    assert!(
        first.held_out.nrmse_after < 0.5 * first.held_out.nrmse_before,
        "{text}"
    );
    let (again, _) = answer(&truth, &improved, 2);
    assert_eq!(
        again.verdict,
        Verdict::Match,
        "{}",
        serde_json::to_string(&again).unwrap()
    );
}
