//! Recordings of simulated robots, for tests and benchmarks of what reads recordings.
//!
//! The plant takes steps of 0.5 ms, not those of a fit, so that a fit of the same model still differs
//! from the recording as two integrators do.

#![expect(
    clippy::unwrap_used,
    reason = "used by tests only, which stop at what they do not expect"
)]

use slipstream_bus::{Camera, RobotModel, Sensors};
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command as Told, Pose, Robot, Stream, Wheels};
use slipstream_sim::{Command, Setup, World};

/// Torques (N m, right and left) under which the wheels of the paper's robot never slip, each held for 20 ms.
pub fn gentle(t_s: f64) -> [f64; 2] {
    let t = (t_s / 0.02).floor() * 0.02;
    [
        0.04 * (0.9 * t).sin() + 0.02 * (3.1 * t).sin(),
        0.04 * (0.9 * t + 0.3).sin(),
    ]
}

/// A recording of `model`, `length_s` long: torque commands (N m, right and left, as a function of time in s) every
/// 20 ms, encoders of 1856 counts per turn, and a noisy overhead camera. `seed` sets the noise.
///
/// # Panics
/// On a model that cannot be simulated.
pub fn record(
    model: &RobotModel,
    torque: fn(f64) -> [f64; 2],
    length_s: f64,
    seed: u64,
) -> Recording {
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
    let mut told = [0.0; 2];
    for k in 0..(length_s / 5e-4).round() as u32 {
        let t_s = f64::from(k) * 5e-4;
        if k % 40 == 0 {
            told = torque(t_s + 1e-6);
        }
        let [right_nm, left_nm] = told;
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
