//! A case of any effect of the catalogue, simulated by the plant itself: for effects that the second
//! simulator does not know.
//!
//! It shows that the diagnosis recovers the effect. It does not show that the plant is right, which only
//! a simulator without shared code can.

use std::collections::BTreeMap;

use slipstream_bus::{EffectSpec, Parameter, RobotModel};
use slipstream_sim::effects::{Channel, Domain, Info, ParameterInfo, Role, When, find};
use slipstream_sim::{Command, Robot, State as PlantState, Stream as PlantStream};
use slipstream_trial_plant::{Commands, Physics, State};

use super::case::{MadeCase, value};
use super::manoeuvre::{COMMAND_PERIOD_S, CommandKind, Style, desired_twists, open_loop};
use super::random::RandomStream;
use super::record::record;
use super::scene::{Camera, Control, Recorded, Scene, Start, TrueRobot};
use super::sensors::{Sensors, Stream, sample_times};
use super::simulate::{SimulatedRobot, SimulatedScene};
use super::truth::Truth;
use crate::label::{ConcealedEffect, DiagnosisVerdict, Label};

/// Length of the recording (s).
const DURATION_S: f64 = 24.0;
/// Longest step of the plant (s).
const STEP_S: f64 = 5e-4;

/// Makes the case of one effect. `size` from 0 to 1 chooses among the probe values of its parameters.
///
/// # Errors
/// An effect that is not in the catalogue, or a model that cannot be simulated.
pub(crate) fn make(
    id: &str,
    size: f64,
    kind: &str,
    seed: u64,
    name: &str,
) -> Result<MadeCase, String> {
    let info = find(id).ok_or_else(|| format!("{id} is not an effect"))?;
    let scene = scene(info, size, kind, seed);
    let simulated = SimulatedScene {
        robots: vec![simulate(&scene)?],
        messages: Vec::new(),
    };
    Ok(MadeCase {
        recording: record(&scene, &simulated, name),
        model: scene.nominal.clone(),
        label: label(info, &scene, name),
    })
}

/// One robot in open loop with encoders, camera and inertial sensor.
fn scene(info: &Info, size: f64, kind: &str, seed: u64) -> Scene {
    let style = if info.acts == When::Sliding {
        Style::Wild
    } else {
        Style::Lively
    };
    Scene {
        kind: kind.to_owned(),
        nominal: RobotModel::default(),
        robots: vec![TrueRobot {
            concealed: vec![effect(info, size)],
            outside: None,
            camera: Camera::Pose,
        }],
        control: Control::Open,
        command_kind: CommandKind::Torque,
        style,
        duration_s: DURATION_S,
        imu: info.channels.contains(&Channel::SensorImu),
        disturbance_n: 0.0,
        noise: None,
        recorded: Recorded::default(),
        start: Start::Rest,
        step_s: STEP_S,
        without: Vec::new(),
        seed,
    }
}

/// The effect with a probe value for each parameter; of alternatives, the one for torques.
fn effect(info: &Info, size: f64) -> EffectSpec {
    let given = |p: &&ParameterInfo| !p.alternative || p.unit == "N m";
    let parameters = info.parameters.iter().filter(given);
    EffectSpec {
        effect: info.id.to_owned(),
        parameters: parameters
            .map(|p| (p.name.to_owned(), parameter(p, size)))
            .collect(),
    }
}

fn parameter(info: &ParameterInfo, size: f64) -> Parameter {
    match info.domain {
        Domain::Text(words) => {
            Parameter::Text(words.first().copied().unwrap_or_default().to_owned())
        }
        Domain::Number { probes: [], .. } if info.role == Role::Time => {
            Parameter::Number(DURATION_S / 2.0)
        }
        Domain::Number { probes, .. } => {
            let last = probes.len().saturating_sub(1);
            let at = (last as f64 * size).round() as usize;
            Parameter::Number(probes.get(at).copied().unwrap_or(0.0))
        }
        Domain::List { .. } => Parameter::List(vec![0.0]),
    }
}

/// Simulates the robot of a scene with the plant.
fn simulate(scene: &Scene) -> Result<SimulatedRobot, String> {
    let robot = Robot::new(&scene.model(0)).map_err(|error| error.to_string())?;
    let nominal = Physics::new(&scene.nominal)?;
    let random = |stream: u64| RandomStream::new(scene.seed, stream);
    let desired = desired_twists(scene.style, scene.duration_s, &mut random(1));
    let times = sample_times(scene.duration_s, [true, true, scene.imu], &mut random(2));
    let mut phases = random(3);
    let mut truth = Truth::new(Sensors::new(&[], [0.0; 2]), times);
    let mut state = robot.start([0.0; 3]);
    let mut t_s = 0.0;
    for k in 0..desired.len() {
        let torque = open_loop(scene.command_kind, &desired, k, &nominal);
        truth.commands.push(torque);
        let [right_nm, left_nm] = torque;
        let command = Command::Torque { right_nm, left_nm };
        let until_s = (k + 1) as f64 * COMMAND_PERIOD_S;
        while t_s < until_s {
            let next_s = next_sample_s(&truth).min(t_s + STEP_S).min(until_s);
            if next_s > t_s {
                robot.step(&mut state, t_s, next_s - t_s, &command);
                t_s = next_s;
            }
            sample(&robot, &state, t_s, &mut truth);
        }
    }
    // Only predictions by the second simulator read these commands; the recording has those of `truth`.
    let commands = Commands {
        quantity: scene.command_kind.quantity(),
        rows: Vec::new(),
    };
    Ok(SimulatedRobot {
        commands,
        truth,
        phase: [phases.unit(), phases.unit()],
    })
}

/// The next sample time of any stream (s).
fn next_sample_s(truth: &Truth) -> f64 {
    let streams = truth.sample_times.0.iter().zip(&truth.sampled);
    let next = streams.filter_map(|(times, sampled)| times.get(sampled.len()));
    next.copied().fold(f64::INFINITY, f64::min)
}

/// Adds the samples that are due at `t_s` to each stream.
fn sample(robot: &Robot, state: &PlantState, t_s: f64, truth: &mut Truth) {
    let streams = [
        (Stream::Wheels, PlantStream::Wheels),
        (Stream::Pose, PlantStream::Pose),
        (Stream::Imu, PlantStream::Imu),
    ];
    for (stream, plant_stream) in streams {
        let at = stream as usize;
        while truth.sample_times.0[at]
            .get(truth.sampled[at].len())
            .is_some_and(|&due_s| due_s <= t_s)
        {
            let stamp_s = robot.stamp_s(plant_stream, t_s);
            truth.sampled[at].push(measured(robot, state, stamp_s));
        }
    }
}

/// What the sensors measure, with offsets and scales, as the state of a robot with ideal sensors.
fn measured(robot: &Robot, state: &PlantState, stamp_s: f64) -> State {
    let [along, across, yaw_rate] = robot.measured_inertial(state);
    let mut measured = State::at(robot.measured_pose(state.pose()));
    measured.t_s = stamp_s;
    measured.motor = robot.measured_angle(state);
    measured.acceleration = [along, across];
    measured.velocity[2] = yaw_rate;
    measured
}

fn label(info: &Info, scene: &Scene, name: &str) -> Label {
    let concealed = scene.robots[0].concealed.iter();
    let effects = concealed.map(|effect| ConcealedEffect {
        effect: effect.effect.clone(),
        robot: Scene::name(0),
        parameters: effect.parameters.iter().map(value).collect(),
        channels: info.channels.iter().map(|c| c.name().to_owned()).collect(),
        confusions: Vec::new(),
        intervals_s: Vec::new(),
        expected_gain: None,
        deviations: BTreeMap::new(),
        runs: Vec::new(),
        tolerances: BTreeMap::new(),
    });
    Label {
        verdict: DiagnosisVerdict::Explained,
        robot_toml: format!("robots/{name}.toml"),
        kind: scene.kind.clone(),
        notes: BTreeMap::from([("simulator".to_owned(), "slipstream-sim".to_owned())]),
        without: Vec::new(),
        nuisances: Vec::new(),
        allowed: Vec::new(),
        effects: effects.collect(),
        unknown: None,
    }
}
