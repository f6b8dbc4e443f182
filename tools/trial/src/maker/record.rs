//! The recording of a simulated scene.

use std::f64::consts::TAU;

use slipstream_recording::recording::{
    Command, Imu, ImuKind, Links, Noise, Pose, Recording, Robot, Stream as Rows, Wheels,
};

use super::manoeuvre::{COMMAND_PERIOD_S, CommandKind, rounded};
use super::random::RandomStream;
use super::scene::{Camera, Control, Scene};
use super::sensors::{IMU_M_S2, IMU_RAD_S, POSE_M, POSE_RAD, Stream, wrapped};
use super::simulate::{SimulatedRobot, SimulatedScene};

/// The recording of a scene; its name does not reveal the content.
pub(crate) fn record(scene: &Scene, simulated: &SimulatedScene, name: &str) -> Recording {
    let robots = simulated.robots.iter().enumerate();
    let messages = simulated.messages.clone();
    Recording {
        name: name.to_owned(),
        origin: "slipstream trial".to_owned(),
        robots: robots
            .map(|(i, robot_run)| robot(scene, i, robot_run))
            .collect(),
        links: (scene.control == Control::Platoon).then(|| Links {
            messages,
            ..Links::default()
        }),
        ..Recording::default()
    }
}

fn robot(scene: &Scene, i: usize, robot_run: &SimulatedRobot) -> Robot {
    let random = |stream: u64| RandomStream::new(scene.seed, 1000 + 10 * i as u64 + stream);
    let camera = scene.robots[i].camera;
    let counts = scene
        .nominal
        .encoder
        .as_ref()
        .map(|encoder| encoder.counts_per_rev);
    let mut robot = Robot::named(Scene::name(i));
    robot.encoder_counts_per_rev = counts;
    robot.command = Some(command(scene.command_kind, &robot_run.truth.commands));
    robot.wheels = scene
        .recorded
        .wheels
        .then(|| wheels(robot_run, scene.counts_per_rev()));
    if camera != Camera::Absent {
        robot.pose = Some(pose(robot_run, camera, &mut random(1)));
        robot.noise = Noise {
            pose_m: Some(POSE_M),
            pose_rad: (camera == Camera::Pose).then_some(POSE_RAD),
            ..Noise::default()
        };
    }
    if scene.imu {
        let mut rows = imu(robot_run, &mut random(2));
        if scene.recorded.accelerometer {
            robot.imu_kind = Some(ImuKind::SpecificForce);
            robot.noise.imu_m_s2 = Some(IMU_M_S2);
        } else {
            rows.values.ax_m_s2 = None;
            rows.values.ay_m_s2 = None;
        }
        robot.imu = Some(rows);
        robot.noise.imu_rad_s = Some(IMU_RAD_S);
    }
    robot
}

fn command(kind: CommandKind, rows: &[[f64; 2]]) -> Rows<Command> {
    let column = |at: usize| rows.iter().map(|row| row[at]).collect();
    let (first, second) = (column(0), column(1));
    Rows {
        t_s: (0..rows.len())
            .map(|k| rounded(k as f64 * COMMAND_PERIOD_S))
            .collect(),
        values: match kind {
            CommandKind::Torque => Command::Torque {
                right_nm: first,
                left_nm: second,
            },
            CommandKind::Voltage => Command::Voltage {
                right_v: first,
                left_v: second,
            },
            CommandKind::WheelSpeed => Command::WheelSpeed {
                right_rad_s: first,
                left_rad_s: second,
            },
            CommandKind::Twist => Command::Twist {
                v_m_s: first,
                w_rad_s: second,
            },
        },
        unknown: Vec::new(),
    }
}

/// The time stamps of a stream that are not before the start, and the indices of their samples.
fn stamps(robot_run: &SimulatedRobot, stream: Stream) -> (Vec<f64>, Vec<usize>) {
    let truth = &robot_run.truth;
    let stamps = truth.sampled[stream as usize].iter().map(|state| state.t_s);
    let stamps = stamps.map(|t_s| rounded(truth.sensors.stamp_s(stream, t_s)));
    stamps
        .enumerate()
        .filter(|(_, t_s)| *t_s >= 0.0)
        .map(|(at, t_s)| (t_s, at))
        .unzip()
}

fn wheels(robot_run: &SimulatedRobot, counts: f64) -> Rows<Wheels> {
    let (t_s, indices) = stamps(robot_run, Stream::Wheels);
    let column = |wheel: usize| {
        let count = |&at: &usize| {
            let state = &robot_run.truth.sampled[Stream::Wheels as usize][at];
            let turns = robot_run.truth.sensors.angles(state)[wheel] / TAU;
            Some((turns * counts + robot_run.phase[wheel]).floor() as i64)
        };
        indices.iter().map(count).collect()
    };
    Rows {
        values: Wheels::Ticks {
            right: column(0),
            left: column(1),
        },
        t_s,
        unknown: Vec::new(),
    }
}

fn pose(robot_run: &SimulatedRobot, camera: Camera, random: &mut RandomStream) -> Rows<Pose> {
    let (t_s, indices) = stamps(robot_run, Stream::Pose);
    let noise = [POSE_M, POSE_M, POSE_RAD];
    let measured: Vec<[f64; 3]> = indices
        .iter()
        .map(|&at| {
            let [x, y, yaw] = robot_run
                .truth
                .sensors
                .pose(&robot_run.truth.sampled[Stream::Pose as usize][at]);
            let [x, y, yaw] = [0, 1, 2].map(|i| [x, y, yaw][i] + random.normal(noise[i]));
            [rounded(x), rounded(y), rounded(wrapped(yaw))]
        })
        .collect();
    let column = |i: usize| measured.iter().map(|pose| pose[i]).collect();
    Rows {
        t_s,
        values: Pose {
            x_m: column(0),
            y_m: column(1),
            yaw_rad: (camera == Camera::Pose).then(|| column(2)),
        },
        unknown: Vec::new(),
    }
}

fn imu(robot_run: &SimulatedRobot, random: &mut RandomStream) -> Rows<Imu> {
    let (t_s, indices) = stamps(robot_run, Stream::Imu);
    let noise = [IMU_M_S2, IMU_M_S2, IMU_RAD_S];
    let measured: Vec<[f64; 3]> = indices
        .iter()
        .map(|&at| {
            let true_values = robot_run
                .truth
                .sensors
                .inertial(&robot_run.truth.sampled[Stream::Imu as usize][at]);
            [0, 1, 2].map(|i| rounded(true_values[i] + random.normal(noise[i])))
        })
        .collect();
    let column = |i: usize| Some(measured.iter().map(|values| values[i]).collect());
    Rows {
        t_s,
        values: Imu {
            ax_m_s2: column(0),
            ay_m_s2: column(1),
            gz_rad_s: column(2),
        },
        unknown: Vec::new(),
    }
}
