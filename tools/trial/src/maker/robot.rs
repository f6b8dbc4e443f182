//! A robot during the simulation of a scene.

use std::f64::consts::TAU;

use slipstream_trial_plant::{Commands, Plant, State};

use super::controller::Controller;
use super::manoeuvre::{COMMAND_PERIOD_S, CommandKind, Style, rounded};
use super::process_noise::{NOISE_PERIOD_S, NoiseProcess};
use super::random::RandomStream;
use super::reference::{Reference, SPACING_M};
use super::scene::{Camera, Control, Scene, Start};
use super::sensors::{Sensors, sample_times};
use super::truth::{Truth, WINDOW_S};

/// Correlation time of the disturbance (s).
const CORRELATION_S: f64 = 0.3;
/// Number of random streams reserved for the scene, and for each robot.
const STREAMS: u64 = 16;
/// Torque limit of the controller (N m): within the limits of friction, and beyond.
const TORQUE_LIMITS_NM: [f64; 2] = [0.085, 0.14];

/// A robot during the simulation of a scene.
pub(crate) struct Robot {
    plant: Plant,
    pub(crate) state: State,
    /// Commands as they reached the drives of its wheels.
    pub(crate) commands: Commands,
    pub(crate) truth: Truth,
    controller: Option<Controller>,
    /// Phase of the encoders, in counts.
    pub(crate) phase: [f64; 2],
    disturbance: RandomStream,
    noise: Option<NoiseProcess>,
}

impl Robot {
    /// Robot `i` of a scene at its initial pose. `first` is the first desired [v (m/s), w (rad/s)].
    ///
    /// # Errors
    /// A model that cannot be simulated.
    pub(crate) fn new(scene: &Scene, i: usize, first: [f64; 2]) -> Result<Self, String> {
        let random =
            |purpose: u64| RandomStream::new(scene.seed, STREAMS * (i as u64 + 1) + purpose);
        let physics = scene.physics(i)?;
        let camera = scene.robots[i].camera;
        let sensors = Sensors::new(&scene.model(i).effects, physics.grade);
        let sample_times = sample_times(
            scene.duration_s,
            [scene.recorded.wheels, camera != Camera::Absent, scene.imu],
            &mut random(1),
        );
        let mut phases = random(2);
        let phase = [phases.unit(), phases.unit()];
        let quantity = scene.command_kind.quantity();
        let plant = Plant::new(physics, quantity, scene.step_s);
        let mut initial = RandomStream::new(scene.seed, 3);
        let yaw = initial.uniform(-3.0, 3.0);
        let ahead = -SPACING_M * i as f64;
        let (x, y) = (initial.uniform(-0.5, 0.5), initial.uniform(-0.5, 0.5));
        let state = plant.start([x + ahead * yaw.cos(), y + ahead * yaw.sin(), yaw]);
        let state = started(&plant, state, scene, first);
        let mut truth = Truth::new(sensors, sample_times);
        truth.window_starts.push(state);
        truth.poses.push(state.pose);
        let mut robot = Self {
            plant,
            state,
            commands: Commands {
                quantity,
                rows: Vec::new(),
            },
            truth,
            controller: None,
            phase,
            disturbance: random(3),
            noise: scene.noise.map(|noise| NoiseProcess::new(noise, random(4))),
        };
        if scene.control != Control::Open {
            robot.controller = Some(robot.new_controller(scene));
        }
        Ok(robot)
    }

    fn new_controller(&self, scene: &Scene) -> Controller {
        let body = &scene.nominal.robot;
        let counts_per_rev = scene.counts_per_rev();
        let geometry = [
            body.wheel_radius_m,
            body.half_track_m,
            body.com_to_axle_m.unwrap_or(0.0),
            counts_per_rev,
        ];
        let [within_friction, beyond_friction] = TORQUE_LIMITS_NM;
        let limit = if scene.style == Style::Wild {
            beyond_friction
        } else {
            within_friction
        };
        Controller::new(
            self.state.pose,
            self.counts(counts_per_rev),
            geometry,
            limit,
        )
    }

    /// The encoder counts, [right, left].
    fn counts(&self, counts_per_rev: f64) -> [i64; 2] {
        let angles = self.truth.sensors.angles(&self.state);
        [0, 1].map(|i| (angles[i] * counts_per_rev / TAU + self.phase[i]).floor() as i64)
    }

    /// Pose of the centre of mass at a past time (s); the initial pose before the start.
    pub(crate) fn pose_at(&self, t_s: f64) -> [f64; 3] {
        let index = (t_s / COMMAND_PERIOD_S).max(0.0);
        let poses = &self.truth.poses;
        let at = (index as usize).min(poses.len() - 1);
        let next = poses[(at + 1).min(poses.len() - 1)];
        let share = index - at as f64;
        std::array::from_fn(|i| poses[at][i] + (next[i] - poses[at][i]) * share)
    }

    /// The controller's torques at a tick (N m).
    pub(crate) fn decide(&mut self, tick: usize, reference: &Reference) -> [f64; 2] {
        let counts_per_rev = self
            .controller
            .as_ref()
            .map_or(1.0, Controller::counts_per_rev);
        let counts = self.counts(counts_per_rev);
        let torque = self
            .controller
            .as_mut()
            .map(|controller| controller.torque(tick, counts, reference));
        torque.unwrap_or([0.0; 2]).map(rounded)
    }

    /// Applies a command until the next.
    pub(crate) fn apply(&mut self, scene: &Scene, k: usize, command: [f64; 2]) {
        let (t_s, to_s) = (
            k as f64 * COMMAND_PERIOD_S,
            (k + 1) as f64 * COMMAND_PERIOD_S,
        );
        let at_wheels = match scene.command_kind {
            CommandKind::Twist => Commands::wheel_speeds(command, self.plant.physics.nominal),
            _ => command,
        };
        self.truth.commands.push(command);
        self.commands.rows.push((t_s, at_wheels));
        let mut until_s = t_s;
        while until_s < to_s - 1e-9 {
            until_s = if scene.disturbance_n > 0.0 || self.noise.is_some() {
                (until_s + NOISE_PERIOD_S).min(to_s)
            } else {
                to_s
            };
            self.disturb(scene.disturbance_n);
            if let Some(noise) = &mut self.noise {
                noise.step(&self.plant.physics, &mut self.state);
            }
            let Self {
                plant,
                state,
                commands,
                truth,
                ..
            } = self;
            plant.advance(commands, state, until_s, |before, after| {
                truth.add_step(&plant.physics.outside, before, after);
            });
        }
        self.truth.poses.push(self.state.pose);
        if ((k + 1) as f64 * COMMAND_PERIOD_S + 1e-9) % WINDOW_S < 1e-6 {
            self.truth.window_starts.push(self.state);
        }
    }

    /// Exact step of an Ornstein-Uhlenbeck process over one period of the disturbance.
    fn disturb(&mut self, deviation: f64) {
        if deviation > 0.0 {
            let decay = (-NOISE_PERIOD_S / CORRELATION_S).exp();
            let innovation = (1.0 - decay * decay).sqrt();
            for (value, share) in self.state.disturbance.iter_mut().zip([1.0, 1.0, 0.1]) {
                *value = *value * decay + self.disturbance.normal(deviation * share * innovation);
            }
        }
    }
}

/// The first state of a robot whose state at rest is `state`.
fn started(plant: &Plant, state: State, scene: &Scene, [v, w]: [f64; 2]) -> State {
    let [radius, half_track] = plant.physics.nominal;
    let (body, sideways) = match scene.start {
        Start::Rest | Start::Pressing { .. } => return state,
        Start::Moving => ([v, w], 0.0),
        Start::Sliding { sideways_m_s } => ([v / 2.0, w], sideways_m_s),
    };
    let mut moving = state;
    let wheels = Commands::wheel_speeds([v, w], [radius, half_track]);
    let across = plant.physics.to_axle * w + sideways;
    moving.velocity = [
        body[0], across, body[1], wheels[0], wheels[1], wheels[0], wheels[1],
    ];
    let commands = Commands {
        quantity: scene.command_kind.quantity(),
        rows: Vec::new(),
    };
    plant.adopt(&moving, &commands)
}
