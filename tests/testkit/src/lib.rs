//! Recordings of simulated robots, for tests and benchmarks of what reads recordings.
//!
//! The plant takes steps of 0.5 ms, not those of a fit, so that a fit of the same model still differs
//! from the recording as two integrators do.

#![expect(
    clippy::unwrap_used,
    reason = "used by tests only, which stop at what they do not expect"
)]

use slipstream_bus::{Body, Camera, RobotModel, Sensors};
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command as Commands, Pose, Robot, Stream, Wheels};
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
    let setup = Setup {
        name: "r1".to_owned(),
        model: model.clone(),
        pose: [0.0; 3],
        sensors: Sensors {
            camera: Some(Camera::default()),
            imu: None,
        },
    };
    let mut world = World::new(&[setup], seed).unwrap();
    let mut rows = StampedRows::default();
    let mut command = [0.0; 2];
    for k in 0..(length_s / STEP_S).round() as u32 {
        let t_s = f64::from(k) * STEP_S;
        if k % STEPS_PER_COMMAND == 0 {
            command = torque(t_s + 1e-6);
            rows.command.push((t_s, command));
            rows.wheels.push((t_s, world.encoder_counts(0)));
        }
        let [right_nm, left_nm] = command;
        world.step(STEP_NS, &[Command::Torque { right_nm, left_nm }]);
        if let Some(frame) = world.camera(0) {
            rows.pose.push((frame.stamp_ns as f64 * 1e-9, frame.value));
        }
    }
    Recording {
        name: "truth".to_owned(),
        robots: vec![rows.into_robot()],
        ..Recording::default()
    }
}

/// Step of the plant (s, ns).
const STEP_S: f64 = 5e-4;
const STEP_NS: i64 = 500_000;
/// A command, and an encoder sample, every 20 ms.
const STEPS_PER_COMMAND: u32 = 40;

/// Rows of the streams, each with its time (s).
#[derive(Default)]
struct StampedRows {
    command: Vec<(f64, [f64; 2])>,
    wheels: Vec<(f64, [i64; 2])>,
    pose: Vec<(f64, [f64; 3])>,
}

impl StampedRows {
    fn into_robot(self) -> Robot {
        let mut robot = Robot::named("r1");
        robot.encoder_counts_per_rev = Some(1856.0);
        robot.noise.pose_m = Some(0.002);
        robot.noise.pose_rad = Some(0.009);
        let torque = |side: usize| self.command.iter().map(|row| row.1[side]).collect();
        let commands = Commands::Torque {
            right_nm: torque(0),
            left_nm: torque(1),
        };
        robot.command = Some(stream(&self.command, commands));
        let ticks = |side: usize| self.wheels.iter().map(|row| Some(row.1[side])).collect();
        let wheels = Wheels::Ticks {
            right: ticks(0),
            left: ticks(1),
        };
        robot.wheels = Some(stream(&self.wheels, wheels));
        let axis = |axis: usize| self.pose.iter().map(|row| row.1[axis]).collect();
        let pose = Pose {
            x_m: axis(0),
            y_m: axis(1),
            yaw_rad: Some(axis(2)),
        };
        robot.pose = Some(stream(&self.pose, pose));
        robot
    }
}

fn stream<T, V>(rows: &[(f64, T)], values: V) -> Stream<V> {
    Stream {
        t_s: rows.iter().map(|(t_s, _)| *t_s).collect(),
        values,
        unknown: Vec::new(),
    }
}

/// A robot of which radius and half track (m) alone are known.
pub fn kinematic(wheel_radius_m: f64, half_track_m: f64) -> RobotModel {
    RobotModel {
        robot: Body::kinematic(wheel_radius_m, half_track_m),
        motor: None,
        encoder: None,
        effects: Vec::new(),
    }
}
