//! `slipstream compare`: the simulation of the recorded commands beside the recording.
//!
//! Open loop from the first command to the last row. Only where it starts is fitted, to the poses
//! of the first half second. Where no command was recorded, the wheels drive the simulation.

use std::f64::consts::TAU;

use slipstream_bus::{InputError, RobotModel};
use slipstream_sim::{Command as Told, CommandKind, Robot as Plant, State};

use crate::check::unwrap;
use crate::recording::{Command, PosePoint, Recording, Robot, Stream, Wheels};

/// Longest step of the simulation (s).
const STEP_S: f64 = 1e-3;
/// The start is fitted to the poses of so long a time (s).
const START_S: f64 = 0.5;
/// Time between the simulated samples that are kept (s).
const SAMPLE_S: f64 = 5e-3;

/// One quantity, recorded and simulated.
#[derive(Debug, Clone)]
pub struct Channel {
    /// The robot.
    pub robot: String,
    /// What it is, such as `pose x`.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Recorded: time (s) and value.
    pub recorded: Vec<(f64, f64)>,
    /// Simulated: time (s) and value.
    pub simulated: Vec<(f64, f64)>,
}

impl Channel {
    /// Root mean square of recorded minus simulated, where both are there.
    pub fn rms_difference(&self) -> Option<f64> {
        let differences = self.recorded.iter().filter_map(|(t_s, value)| {
            let difference = value - interpolate(&self.simulated, *t_s)?;
            difference.is_finite().then_some(difference)
        });
        let (sum, n) = differences.fold((0.0, 0), |(sum, n), d| (sum + d * d, n + 1));
        (n > 0).then(|| (sum / f64::from(n)).sqrt())
    }
}

/// Why nothing can be laid side by side.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// A robot has no model.
    #[error("no model for {0}; give one with --robot")]
    NoModel(String),
    /// The simulation refuses a robot's model.
    #[error("the model of {robot}: {source}")]
    Model {
        /// The robot.
        robot: String,
        /// What is wrong with its model.
        source: InputError,
    },
    /// Nothing drives a simulation.
    #[error(
        "neither command.csv nor wheels.csv of any robot has two rows; record what the drives \
         were told"
    )]
    NothingToSimulate,
}

/// Simulates every robot that recorded commands or wheels, and lays both side by side.
///
/// # Errors
/// A robot without a model or with one that the simulation refuses, or a recording without anything
/// to drive it.
pub fn compare(
    recording: &Recording,
    model_of: impl Fn(&str) -> Option<RobotModel>,
) -> Result<Vec<Channel>, CompareError> {
    let mut channels = Vec::new();
    for robot in &recording.robots {
        let Some(model) = model_of(&robot.name).or_else(|| recording.model.clone()) else {
            return Err(CompareError::NoModel(robot.name.clone()));
        };
        if let Some(commands) = commands(robot, &model) {
            let refused = |source| CompareError::Model {
                robot: robot.name.clone(),
                source,
            };
            let plant = Plant::new(&model).map_err(refused)?;
            plant.accepts(kind(&commands)).map_err(refused)?;
            let start = fit_start(&plant, robot, &model, &commands);
            let run = simulate(&plant, robot, start, &commands, f64::INFINITY);
            channels.extend(of_robot(robot, &model, &run));
        }
    }
    if channels.is_empty() {
        return Err(CompareError::NothingToSimulate);
    }
    Ok(channels)
}

/// What the plant is told, from when (s).
type Commands = Vec<(f64, Told)>;

/// The recorded commands; without them the wheels' speeds. Empty cells repeat the row before.
fn commands(robot: &Robot, model: &RobotModel) -> Option<Commands> {
    if let Some(command) = &robot.command {
        let (a, b, told): (_, _, fn(f64, f64) -> Told) = match &command.values {
            Command::Torque { right_nm, left_nm } => (right_nm, left_nm, |right_nm, left_nm| {
                Told::Torque { right_nm, left_nm }
            }),
            Command::Voltage { right_v, left_v } => (right_v, left_v, |right_v, left_v| {
                Told::Voltage { right_v, left_v }
            }),
            Command::WheelSpeed {
                right_rad_s,
                left_rad_s,
            } => (right_rad_s, left_rad_s, speed),
            Command::Twist { v_m_s, w_rad_s } => (v_m_s, w_rad_s, |v_m_s, w_rad_s| Told::Twist {
                v_m_s,
                w_rad_s,
            }),
        };
        return Some(pairs(&command.t_s, a, b, told)).filter(|rows| rows.len() > 1);
    }
    let wheels = robot.wheels.as_ref()?;
    if let Wheels::Speed {
        right_rad_s,
        left_rad_s,
    } = &wheels.values
    {
        return Some(pairs(&wheels.t_s, right_rad_s, left_rad_s, speed)).filter(|r| r.len() > 1);
    }
    let [right, left] = wheel_angles(robot, model)?;
    let rate = |angle: &[f64]| -> Vec<f64> {
        let steps = wheels.t_s.iter().zip(wheels.t_s.iter().skip(1));
        let turns = angle.iter().zip(angle.iter().skip(1));
        let rate = |((t_a, t_b), (a, b)): ((&f64, &f64), (&f64, &f64))| (b - a) / (t_b - t_a);
        steps.zip(turns).map(rate).chain([0.0]).collect()
    };
    Some(pairs(&wheels.t_s, &rate(&right), &rate(&left), speed)).filter(|rows| rows.len() > 1)
}

/// What the commands set at the wheels.
fn kind(commands: &[(f64, Told)]) -> CommandKind {
    match commands.first() {
        Some((_, Told::Torque { .. })) => CommandKind::Torque,
        Some((_, Told::Voltage { .. })) => CommandKind::Voltage,
        _ => CommandKind::Speed,
    }
}

fn speed(right_rad_s: f64, left_rad_s: f64) -> Told {
    Told::Speed {
        right_rad_s,
        left_rad_s,
    }
}

fn pairs(times: &[f64], a: &[f64], b: &[f64], told: fn(f64, f64) -> Told) -> Commands {
    let mut last = [0.0; 2];
    let rows = times.iter().zip(a.iter().zip(b));
    rows.map(|(t_s, (a, b))| {
        for (last, now) in last.iter_mut().zip([a, b]) {
            if now.is_finite() {
                *last = *now;
            }
        }
        (*t_s, told(last[0], last[1]))
    })
    .collect()
}

/// Wheel angles (rad), [right, left], where they can be had.
fn wheel_angles(robot: &Robot, model: &RobotModel) -> Option<[Vec<f64>; 2]> {
    match &robot.wheels.as_ref()?.values {
        Wheels::Angle {
            right_rad,
            left_rad,
        } => Some([right_rad.clone(), left_rad.clone()]),
        Wheels::Ticks { right, left } => {
            let of_model = model.encoder.as_ref().map(|encoder| encoder.counts_per_rev);
            let counts = robot.encoder_counts_per_rev.or(of_model)?;
            let rad_per_count = TAU / f64::from(counts);
            let angle = |count: &Option<i64>| count.map_or(f64::NAN, |c| c as f64 * rad_per_count);
            Some([right, left].map(|counts| counts.iter().map(angle).collect()))
        }
        Wheels::Speed { .. } => None,
    }
}

/// A simulated state at a time (s).
struct Sample {
    t_s: f64,
    pose: [f64; 3],
    velocity: [f64; 3],
    acceleration: [f64; 2],
    angle: [f64; 2],
    speed: [f64; 2],
}

/// Simulates from `start`, no longer than to `until_s`.
fn simulate(
    plant: &Plant,
    robot: &Robot,
    start: [f64; 3],
    commands: &[(f64, Told)],
    until_s: f64,
) -> Vec<Sample> {
    let start_s = commands.first().map_or(0.0, |(t_s, _)| *t_s);
    let last = commands.last().map_or(0.0, |(t_s, _)| *t_s);
    let ends = [
        robot.pose.as_ref().and_then(|s| s.t_s.last().copied()),
        robot.wheels.as_ref().and_then(|s| s.t_s.last().copied()),
    ];
    // The last command holds for as long as anything was seen, but not for a stray stamp.
    let end_s = ends
        .into_iter()
        .flatten()
        .fold(last, f64::max)
        .min(last + 1.0);
    let end_s = end_s.min(until_s);
    let mut state = plant.start(start);
    let mut samples = vec![sample(plant, start_s, &state)];
    let mut next_sample_s = start_s + SAMPLE_S;
    for (i, (from_s, told)) in commands.iter().enumerate() {
        let next = commands.get(i + 1).map_or(end_s, |(t_s, _)| *t_s);
        let to_s = next.min(end_s);
        let steps = ((to_s - from_s) / STEP_S).ceil().max(0.0);
        let step_s = if steps > 0.0 {
            (to_s - from_s) / steps
        } else {
            0.0
        };
        for k in 0..steps as u64 {
            let t_s = from_s + k as f64 * step_s;
            plant.step(&mut state, t_s - start_s, step_s, told);
            if t_s + step_s >= next_sample_s {
                samples.push(sample(plant, t_s + step_s, &state));
                next_sample_s = t_s + step_s + SAMPLE_S;
            }
        }
    }
    samples
}

fn sample(plant: &Plant, t_s: f64, state: &State) -> Sample {
    let [along, across, _] = state.acceleration();
    Sample {
        t_s,
        pose: state.pose(),
        velocity: state.velocity(),
        acceleration: [along, across],
        angle: plant.measured_angle(state),
        speed: state.wheel_speed(),
    }
}

/// Distance from the tracked point forward to c (m).
fn tracked_to_com_m(robot: &Robot, model: &RobotModel) -> f64 {
    match robot.pose_point {
        Some(PosePoint::Axle) => model.robot.com_to_axle_m.unwrap_or(0.0),
        _ => 0.0,
    }
}

/// Where c stands at the first complete row of the pose; the origin without one.
fn start_pose(robot: &Robot, model: &RobotModel) -> [f64; 3] {
    let Some(pose) = &robot.pose else {
        return [0.0; 3];
    };
    let yaw = pose.values.yaw_rad.as_deref().unwrap_or_default();
    let mut rows = pose.values.x_m.iter().zip(&pose.values.y_m).zip(yaw);
    let complete = rows.find(|((x, y), yaw)| x.is_finite() && y.is_finite() && yaw.is_finite());
    let Some(((x, y), yaw)) = complete else {
        return [0.0; 3];
    };
    let ahead = tracked_to_com_m(robot, model);
    [x + ahead * yaw.cos(), y + ahead * yaw.sin(), *yaw]
}

/// Where c starts: as the first pose says, then turned and shifted by what is left on average over
/// the first half second, because one pose alone is noisy.
fn fit_start(
    plant: &Plant,
    robot: &Robot,
    model: &RobotModel,
    commands: &[(f64, Told)],
) -> [f64; 3] {
    let first = start_pose(robot, model);
    let (Some(pose), Some((from_s, _))) = (&robot.pose, commands.first()) else {
        return first;
    };
    let until_s = from_s.max(pose.t_s.first().copied().unwrap_or(*from_s)) + START_S;
    let run = simulate(plant, robot, first, commands, until_s);
    let channels = of_robot(robot, model, &run);
    let left = |name: &str| -> f64 {
        let Some(channel) = channels.iter().find(|channel| channel.name == name) else {
            return 0.0;
        };
        let early = channel.recorded.iter().filter(|(t_s, _)| *t_s <= until_s);
        let differences: Vec<f64> = early
            .filter_map(|(t_s, value)| Some(value - interpolate(&channel.simulated, *t_s)?))
            .collect();
        differences.iter().sum::<f64>() / (differences.len() as f64).max(1.0)
    };
    let [x_m, y_m, yaw_rad] = first;
    [
        x_m + left("pose x"),
        y_m + left("pose y"),
        yaw_rad + left("pose yaw"),
    ]
}

/// Recorded beside simulated, for every column that the simulation can tell.
fn of_robot(robot: &Robot, model: &RobotModel, run: &[Sample]) -> Vec<Channel> {
    let mut channels = Vec::new();
    let mut add = |name: &str, unit, t_s: &[f64], seen: &[f64], tell: &dyn Fn(&Sample) -> f64| {
        let recorded = t_s.iter().copied().zip(seen.iter().copied());
        channels.push(Channel {
            robot: robot.name.clone(),
            name: name.to_owned(),
            unit,
            recorded: recorded.filter(|(_, value)| value.is_finite()).collect(),
            simulated: run
                .iter()
                .map(|sample| (sample.t_s, tell(sample)))
                .collect(),
        });
    };
    if let Some(Stream { t_s, values, .. }) = &robot.pose {
        let behind = tracked_to_com_m(robot, model);
        add("pose x", "m", t_s, &values.x_m, &|s| {
            s.pose[0] - behind * s.pose[2].cos()
        });
        add("pose y", "m", t_s, &values.y_m, &|s| {
            s.pose[1] - behind * s.pose[2].sin()
        });
        if let Some(yaw) = &values.yaw_rad {
            add("pose yaw", "rad", t_s, &unwrap(yaw), &|s| s.pose[2]);
        }
    }
    if let (Some(wheels), Some(angles)) = (&robot.wheels, wheel_angles(robot, model)) {
        for (side, (name, angle)) in ["wheel right", "wheel left"]
            .iter()
            .zip(&angles)
            .enumerate()
        {
            // Encoders start anywhere: the first angle is taken as the simulated one.
            let first = angle.iter().copied().find(|a| a.is_finite()).unwrap_or(0.0);
            let turned: Vec<f64> = angle.iter().map(|a| a - first).collect();
            add(name, "rad", &wheels.t_s, &turned, &|s| s.angle[side]);
        }
    }
    if let Some(wheels) = &robot.wheels
        && let Wheels::Speed {
            right_rad_s,
            left_rad_s,
        } = &wheels.values
    {
        add("wheel right", "rad/s", &wheels.t_s, right_rad_s, &|s| {
            s.speed[0]
        });
        add("wheel left", "rad/s", &wheels.t_s, left_rad_s, &|s| {
            s.speed[1]
        });
    }
    if let Some(Stream { t_s, values, .. }) = &robot.imu {
        for (axis, (name, column)) in [("imu ax", &values.ax_m_s2), ("imu ay", &values.ay_m_s2)]
            .into_iter()
            .enumerate()
        {
            if let Some(column) = column {
                add(name, "m/s²", t_s, column, &|s| s.acceleration[axis]);
            }
        }
        if let Some(gz) = &values.gz_rad_s {
            add("imu gz", "rad/s", t_s, gz, &|s| s.velocity[2]);
        }
    }
    if let Some(Stream { t_s, values, .. }) = &robot.odometry {
        add("odometry v", "m/s", t_s, &values.v_m_s, &|s| s.velocity[0]);
        if let Some(w) = &values.w_rad_s {
            add("odometry w", "rad/s", t_s, w, &|s| s.velocity[2]);
        }
    }
    channels
}

/// A straight line between the samples around `t_s`.
fn interpolate(samples: &[(f64, f64)], t_s: f64) -> Option<f64> {
    let after = samples.partition_point(|(time, _)| *time < t_s);
    let (t_b, b) = *samples.get(after)?;
    let (t_a, a) = *samples.get(after.saturating_sub(1))?;
    if t_b <= t_a {
        return (t_b == t_s).then_some(b);
    }
    Some(a + (b - a) * (t_s - t_a) / (t_b - t_a))
}
