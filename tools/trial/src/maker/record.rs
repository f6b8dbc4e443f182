//! What a played scene leaves behind: the recording.

use std::f64::consts::TAU;

use slipstream_recording::recording::{
    Command, ImuKind, Links, Noise, Pose, Recording, Robot, Stream as Rows, Wheels,
};

use super::chance::Chance;
use super::drive::{Actor, Played};
use super::manoeuvre::{HOLD_S, Told, rounded};
use super::scene::{Control, Eye, Scene};
use super::sensors::{IMU_M_S2, IMU_RAD_S, POSE_M, POSE_RAD, Stream, wrapped};

/// The recording of a scene. Its name says nothing of what is in it.
pub(crate) fn record(scene: &Scene, played: &Played, name: &str) -> Recording {
    let robots = played.robots.iter().enumerate();
    let messages = played.messages.clone();
    Recording {
        name: name.to_owned(),
        origin: "slipstream trial".to_owned(),
        robots: robots.map(|(i, actor)| robot(scene, i, actor)).collect(),
        links: (scene.control == Control::Platoon).then(|| Links {
            messages,
            ..Links::default()
        }),
        ..Recording::default()
    }
}

fn robot(scene: &Scene, i: usize, actor: &Actor) -> Robot {
    let chance = |stream: u64| Chance::new(scene.seed, 1000 + 10 * i as u64 + stream);
    let eye = scene.robots[i].eye;
    let counts = scene
        .nominal
        .encoder
        .as_ref()
        .map(|encoder| encoder.counts_per_rev);
    let mut robot = Robot::named(Scene::name(i));
    robot.encoder_counts_per_rev = counts;
    robot.command = Some(command(scene.told, &actor.trace.told));
    robot.wheels = Some(wheels(actor, f64::from(counts.unwrap_or(1856))));
    if eye != Eye::Blind {
        robot.pose = Some(pose(actor, eye, &mut chance(1)));
        robot.noise = Noise {
            pose_m: Some(POSE_M),
            pose_rad: (eye == Eye::Pose).then_some(POSE_RAD),
            ..Noise::default()
        };
    }
    if scene.imu {
        robot.imu = Some(imu(actor, &mut chance(2)));
        robot.imu_kind = Some(ImuKind::SpecificForce);
        robot.noise.imu_m_s2 = Some(IMU_M_S2);
        robot.noise.imu_rad_s = Some(IMU_RAD_S);
    }
    robot
}

fn command(told: Told, rows: &[[f64; 2]]) -> Rows<Command> {
    let column = |at: usize| rows.iter().map(|row| row[at]).collect();
    let (first, second) = (column(0), column(1));
    Rows {
        t_s: (0..rows.len())
            .map(|k| rounded(k as f64 * HOLD_S))
            .collect(),
        values: match told {
            Told::Torque => Command::Torque {
                right_nm: first,
                left_nm: second,
            },
            Told::Voltage => Command::Voltage {
                right_v: first,
                left_v: second,
            },
            Told::WheelSpeed => Command::WheelSpeed {
                right_rad_s: first,
                left_rad_s: second,
            },
            Told::Twist => Command::Twist {
                v_m_s: first,
                w_rad_s: second,
            },
        },
        unknown: Vec::new(),
    }
}

/// The stamps of a stream, and which of its looks have one that is not before the start.
fn stamps(actor: &Actor, stream: Stream) -> (Vec<f64>, Vec<usize>) {
    let trace = &actor.trace;
    let stamps = trace.seen[stream as usize].iter().map(|state| state.t_s);
    let stamps = stamps.map(|t_s| rounded(trace.sensors.stamp_s(stream, t_s)));
    stamps
        .enumerate()
        .filter(|(_, t_s)| *t_s >= 0.0)
        .map(|(at, t_s)| (t_s, at))
        .unzip()
}

fn wheels(actor: &Actor, counts: f64) -> Rows<Wheels> {
    let (t_s, places) = stamps(actor, Stream::Wheels);
    let column = |wheel: usize| {
        let count = |&at: &usize| {
            let state = &actor.trace.seen[Stream::Wheels as usize][at];
            let turns = actor.trace.sensors.angles(state)[wheel] / TAU;
            Some((turns * counts + actor.phase[wheel]).floor() as i64)
        };
        places.iter().map(count).collect()
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

fn pose(actor: &Actor, eye: Eye, chance: &mut Chance) -> Rows<Pose> {
    let (t_s, places) = stamps(actor, Stream::Pose);
    let noise = [POSE_M, POSE_M, POSE_RAD];
    let seen: Vec<[f64; 3]> = places
        .iter()
        .map(|&at| {
            let [x, y, yaw] = actor
                .trace
                .sensors
                .pose(&actor.trace.seen[Stream::Pose as usize][at]);
            let [x, y, yaw] = [0, 1, 2].map(|i| [x, y, yaw][i] + chance.normal(noise[i]));
            [rounded(x), rounded(y), rounded(wrapped(yaw))]
        })
        .collect();
    let column = |i: usize| seen.iter().map(|pose| pose[i]).collect();
    Rows {
        t_s,
        values: Pose {
            x_m: column(0),
            y_m: column(1),
            yaw_rad: (eye == Eye::Pose).then(|| column(2)),
        },
        unknown: Vec::new(),
    }
}

fn imu(actor: &Actor, chance: &mut Chance) -> Rows<slipstream_recording::recording::Imu> {
    let (t_s, places) = stamps(actor, Stream::Imu);
    let noise = [IMU_M_S2, IMU_M_S2, IMU_RAD_S];
    let seen: Vec<[f64; 3]> = places
        .iter()
        .map(|&at| {
            let true_values = actor
                .trace
                .sensors
                .inertial(&actor.trace.seen[Stream::Imu as usize][at]);
            [0, 1, 2].map(|i| rounded(true_values[i] + chance.normal(noise[i])))
        })
        .collect();
    let column = |i: usize| Some(seen.iter().map(|values| values[i]).collect());
    Rows {
        t_s,
        values: slipstream_recording::recording::Imu {
            ax_m_s2: column(0),
            ay_m_s2: column(1),
            gz_rad_s: column(2),
        },
        unknown: Vec::new(),
    }
}
