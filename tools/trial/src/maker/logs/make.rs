//! Draws a case, drives its runs, and writes its log.

use slipstream_bus::{Body, Encoder, RobotModel};
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command, Imu, Noise, Pose, Robot, Stream, Wheels};

use super::effects::conceal;
use super::label::{Lags, label};
use super::log::{Log, Source, purpose, run_name};
use super::nuisances::{self, Apply, TABLE};
use super::plant::Trace;
use super::robot::{PoseKind, WheelKind};
use super::rows::{Quantity, Rows};
use super::sampled;
use crate::maker::case::MadeCase;
use crate::maker::manoeuvre::{CommandKind, rounded};
use crate::maker::random::RandomStream;
use crate::maker::sensors::wrapped;

/// Shares of cases with none, one, two and three effects beside those that nuisances bring.
const EFFECT_COUNTS: [f64; 4] = [0.54, 0.26, 0.13, 0.07];
/// Time between the starts of two runs beyond their duration (s).
const BETWEEN_RUNS_S: f64 = 60.0;

/// Draws a case.
pub(crate) fn draw(seed: u64) -> Log {
    let mut log = Log::plain(seed);
    nuisances::draw(&mut log);
    let mut random = RandomStream::new(seed, purpose::EFFECTS);
    let mut at = random.unit();
    let count = EFFECT_COUNTS.iter().position(|share| {
        at -= share;
        at < 0.0
    });
    conceal(&mut log, count.unwrap_or(0), &mut random);
    log
}

/// Makes a case; `name` is the name of its recording.
pub(crate) fn make(log: &Log, name: &str) -> MadeCase {
    let mut lags = Lags::new(log.runs.len());
    let mut robots = Vec::new();
    let mut start_s = log.epoch_s;
    for run in 0..log.runs.len() {
        robots.push(record(log, run, start_s, &mut lags));
        start_s += log.runs[run].duration_s + BETWEEN_RUNS_S;
    }
    MadeCase {
        recording: Recording {
            name: name.to_owned(),
            origin: "slipstream trial".to_owned(),
            same_robot: log.runs.len() > 1,
            robots,
            ..Recording::default()
        },
        model: model(log),
        label: label(log, name, &lags),
    }
}

/// The nominal model.
fn model(log: &Log) -> RobotModel {
    RobotModel {
        robot: Body::kinematic(log.robot.wheel_radius_m, log.robot.half_track_m),
        motor: None,
        encoder: counts_per_rev(log).map(|counts_per_rev| Encoder { counts_per_rev }),
        effects: Vec::new(),
    }
}

/// Counts per turn, where the log has counters.
fn counts_per_rev(log: &Log) -> Option<f64> {
    let are_ticks = log.streams.wheels == Some(WheelKind::Ticks);
    are_ticks.then(|| log.streams.counts.round())
}

/// One run: driven, measured, and logged.
fn record(log: &Log, run: usize, start_s: f64, lags: &mut Lags) -> Robot {
    let period_s = log.streams.periods_s[Source::Command as usize];
    let trace = log.plant.drive(
        &log.robot,
        &log.runs[run].floor,
        &log.wheel_speeds(run),
        period_s,
        |at| RandomStream::new(log.seed, purpose::WANDER + 20 * run as u64 + at as u64),
    );
    let mut robot = Robot::named(run_name(run));
    robot.encoder_counts_per_rev = counts_per_rev(log);
    if log.sensors.noise_is_known {
        robot.noise = noise(log);
    }
    for source in Source::ALL {
        let Some(rows) = logged(log, source, run, &trace, lags) else {
            continue;
        };
        let drift = 1.0 + log.sensors.drift[source as usize];
        let t_s = rows
            .rows
            .iter()
            .map(|row| rounded(start_s + row.t_s * drift))
            .collect();
        put(log, &mut robot, &rows, t_s);
    }
    robot
}

/// The rows of a source as its logger wrote them.
fn logged(log: &Log, source: Source, run: usize, trace: &Trace, lags: &mut Lags) -> Option<Rows> {
    let mut rows = sampled::rows(log, source, run, trace)?;
    for drawn in &log.nuisances {
        let Apply::Rows(_, apply) = TABLE[drawn.row].apply else {
            continue;
        };
        let place = (100 * run + drawn.row) as u64 * 4 + source as u64;
        let mut random = RandomStream::new(log.seed, purpose::FAULTS + place);
        if drawn.on.contains(&source) && apply(&mut rows, drawn.size, &mut random) {
            lags.applied(drawn.row);
        }
    }
    // What was measured before the log began is not in it.
    rows.rows.retain(|row| row.t_s >= 0.0);
    lags.measured(source, run, rows.lag_s());
    Some(rows)
}

fn noise(log: &Log) -> Noise {
    let [pose_m, pose_rad, gyro_rad_s] = log.sensors.noise;
    let sees_heading = log
        .streams
        .pose
        .is_some_and(|kind| kind != PoseKind::Position);
    Noise {
        pose_m: log.has(Source::Pose).then_some(pose_m),
        pose_rad: sees_heading.then_some(pose_rad),
        imu_rad_s: log.streams.gyro.then_some(gyro_rad_s),
        ..Noise::default()
    }
}

/// Puts rows into the streams of a robot.
fn put(log: &Log, robot: &mut Robot, rows: &Rows, t_s: Vec<f64>) {
    let column =
        |i: usize| -> Vec<f64> { rows.rows.iter().map(|row| rounded(row.values[i])).collect() };
    let counts = |i: usize| {
        rows.rows
            .iter()
            .map(|row| Some(row.values[i] as i64))
            .collect()
    };
    let (right, left) = (|| column(0), || column(1));
    match rows.quantity {
        Quantity::Command if log.streams.command == Some(CommandKind::WheelSpeed) => {
            let values = Command::WheelSpeed {
                right_rad_s: right(),
                left_rad_s: left(),
            };
            robot.command = Some(stream(t_s, values));
        }
        Quantity::Command => {
            let values = Command::Twist {
                v_m_s: right(),
                w_rad_s: left(),
            };
            robot.command = Some(stream(t_s, values));
        }
        Quantity::Counts => {
            robot.wheels = Some(stream(
                t_s,
                Wheels::Ticks {
                    right: counts(0),
                    left: counts(1),
                },
            ));
        }
        Quantity::Angles => {
            robot.wheels = Some(stream(
                t_s,
                Wheels::Angle {
                    right_rad: right(),
                    left_rad: left(),
                },
            ));
        }
        Quantity::Speeds => {
            robot.wheels = Some(stream(
                t_s,
                Wheels::Speed {
                    right_rad_s: right(),
                    left_rad_s: left(),
                },
            ));
        }
        Quantity::Pose => {
            let sees_heading = log.streams.pose != Some(PoseKind::Position);
            let values = Pose {
                x_m: column(0),
                y_m: column(1),
                yaw_rad: sees_heading.then(|| column(2).into_iter().map(wrapped).collect()),
            };
            robot.pose = Some(stream(t_s, values));
        }
        Quantity::Gyro => {
            let values = Imu {
                gz_rad_s: Some(column(0)),
                ..Imu::default()
            };
            robot.imu = Some(stream(t_s, values));
        }
    }
}

fn stream<V>(t_s: Vec<f64>, values: V) -> Stream<V> {
    Stream {
        t_s,
        values,
        unknown: Vec::new(),
    }
}
