//! Simulates a scene: controllers, plants and random disturbances.

use std::f64::consts::TAU;
use std::sync::Arc;

use slipstream_recording::recording::LinkMessage;

use super::controller::{Controller, Reference};
use super::manoeuvre::{COMMAND_PERIOD_S, DesiredTwists, desired_twists, open_loop, rounded};
use super::random::RandomStream;
use super::scene::{Camera, Control, Scene};
use super::sensors::{POSE_M, POSE_RAD, Sensors, sample_times, wrapped};
use super::truth::{Truth, WINDOW_S};
use slipstream_trial_plant::{Commands, Physics, Plant, State};

/// Initial distance interpolate the robots of a platoon (m).
const SPACING_M: f64 = 0.6;
/// Period in which the disturbance changes (s).
const DISTURBANCE_PERIOD_S: f64 = 0.005;
/// Correlation time of the disturbance (s).
const CORRELATION_S: f64 = 0.3;
/// Number of commands from one message to the next.
const MESSAGE_EVERY: usize = 3;

/// Number of random streams reserved for the scene, and for each robot.
const STREAMS: u64 = 16;

/// A simulated robot.
#[derive(Debug)]
pub(crate) struct SimulatedRobot {
    /// Commands as they reached the drives of its wheels.
    pub(crate) commands: Commands,
    pub(crate) truth: Truth,
    /// Phase of the encoders, in counts.
    pub(crate) phase: [f64; 2],
}

/// A simulated scene.
#[derive(Debug)]
pub(crate) struct SimulatedScene {
    pub(crate) robots: Vec<SimulatedRobot>,
    pub(crate) messages: Vec<LinkMessage>,
}

struct Robot {
    plant: Plant,
    state: State,
    commands: Commands,
    truth: Truth,
    controller: Option<Controller>,
    phase: [f64; 2],
    disturbance: RandomStream,
}

/// Simulates a scene.
///
/// # Errors
/// A model that cannot be simulated.
pub(crate) fn simulate(scene: &Scene) -> Result<SimulatedScene, String> {
    let nominal = Physics::new(&scene.nominal)?;
    let desired = desired_twists(
        scene.style,
        scene.duration_s,
        &mut RandomStream::new(scene.seed, 1),
    );
    let mut robots: Vec<Robot> = (0..scene.robots.len())
        .map(|i| Robot::new(scene, i))
        .collect::<Result<_, _>>()?;
    let mut link = RandomStream::new(scene.seed, 2);
    let mut messages: Vec<LinkMessage> = Vec::new();
    let mut path = Path::new(robots.first().map_or([0.0; 3], |robot| robot.state.pose));
    for k in 0..desired.len() {
        let t_s = k as f64 * COMMAND_PERIOD_S;
        if scene.control == Control::Platoon && k % MESSAGE_EVERY == 0 {
            send(scene, &robots, t_s, &mut link, &mut messages);
        }
        for (i, robot) in robots.iter_mut().enumerate() {
            let command = match scene.control {
                Control::Open => open_loop(scene.command_kind, &desired, k, &nominal),
                Control::Closed | Control::Platoon => {
                    let message = if i == 0 {
                        None
                    } else {
                        latest(&messages, i, t_s)
                    };
                    let reference = reference(&path, message, &desired, k, i);
                    robot.decide(k, &reference)
                }
            };
            robot.apply(scene, k, command);
        }
        path.advance(desired[k]);
    }
    let result = |robot: Robot| SimulatedRobot {
        commands: robot.commands,
        truth: robot.truth,
        phase: robot.phase,
    };
    let robots = robots.into_iter().map(result);
    Ok(SimulatedScene {
        robots: robots.collect(),
        messages,
    })
}

impl Robot {
    fn new(scene: &Scene, i: usize) -> Result<Self, String> {
        let random =
            |purpose: u64| RandomStream::new(scene.seed, STREAMS * (i as u64 + 1) + purpose);
        let physics = scene.physics(i)?;
        let camera = scene.robots[i].camera;
        let sensors = Sensors::new(&scene.model(i).effects, physics.grade);
        let sample_times = sample_times(
            scene.duration_s,
            [true, camera != Camera::Absent, scene.imu],
            &mut random(1),
        );
        let mut phases = random(2);
        let phase = [phases.unit(), phases.unit()];
        let quantity = scene.command_kind.quantity();
        let plant = Plant::new(physics, quantity, scene.step_s);
        let mut place = RandomStream::new(scene.seed, 3);
        let yaw = place.uniform(-3.0, 3.0);
        let ahead = -SPACING_M * i as f64;
        let (x, y) = (place.uniform(-0.5, 0.5), place.uniform(-0.5, 0.5));
        let state = plant.start([x + ahead * yaw.cos(), y + ahead * yaw.sin(), yaw]);
        let mut truth = Truth::new(sensors, sample_times);
        truth.window_starts.push(state);
        truth.poses.push(state.pose);
        let body = &scene.nominal.robot;
        let counts = scene
            .nominal
            .encoder
            .as_ref()
            .map_or(1856, |e| e.counts_per_rev);
        let geometry = [
            body.wheel_radius_m,
            body.half_track_m,
            body.com_to_axle_m.unwrap_or(0.0),
            f64::from(counts),
        ];
        let closed = scene.control != Control::Open;
        let limit = if scene.style == super::manoeuvre::Style::Wild {
            0.14
        } else {
            0.085
        };
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
        };
        robot.controller =
            closed.then(|| Controller::new(state.pose, robot.counts(geometry[3]), geometry, limit));
        Ok(robot)
    }

    fn counts(&self, counts_per_rev: f64) -> [i64; 2] {
        let angles = self.truth.sensors.angles(&self.state);
        [0, 1].map(|i| (angles[i] * counts_per_rev / TAU + self.phase[i]).floor() as i64)
    }

    /// Pose of the centre of mass at a past time (s); the initial pose before the start.
    fn pose_at(&self, t_s: f64) -> [f64; 3] {
        let place = (t_s / COMMAND_PERIOD_S).max(0.0);
        let poses = &self.truth.poses;
        let at = (place as usize).min(poses.len() - 1);
        let next = poses[(at + 1).min(poses.len() - 1)];
        let share = place - at as f64;
        std::array::from_fn(|i| poses[at][i] + (next[i] - poses[at][i]) * share)
    }

    fn decide(&mut self, tick: usize, reference: &Reference) -> [f64; 2] {
        let turn = self
            .controller
            .as_ref()
            .map_or(1.0, Controller::counts_per_rev);
        let counts = self.counts(turn);
        let torque = self
            .controller
            .as_mut()
            .map(|own| own.torque(tick, counts, reference));
        torque.unwrap_or([0.0; 2]).map(rounded)
    }

    /// Applies a command until the next.
    fn apply(&mut self, scene: &Scene, k: usize, command: [f64; 2]) {
        let (t_s, to_s) = (
            k as f64 * COMMAND_PERIOD_S,
            (k + 1) as f64 * COMMAND_PERIOD_S,
        );
        let at_wheels = match scene.command_kind {
            super::manoeuvre::CommandKind::Twist => {
                Commands::wheel_speeds(command, self.plant.physics.nominal)
            }
            _ => command,
        };
        self.truth.commands.push(command);
        self.commands.rows.push((t_s, at_wheels));
        let mut until_s = t_s;
        while until_s < to_s - 1e-9 {
            until_s = if scene.disturbance_n > 0.0 {
                (until_s + DISTURBANCE_PERIOD_S).min(to_s)
            } else {
                to_s
            };
            self.disturb(scene.disturbance_n);
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
            let decay = (-DISTURBANCE_PERIOD_S / CORRELATION_S).exp();
            let innovation = (1.0 - decay * decay).sqrt();
            for (value, share) in self.state.disturbance.iter_mut().zip([1.0, 1.0, 0.1]) {
                *value = *value * decay + self.disturbance.normal(deviation * share * innovation);
            }
        }
    }
}

/// The reference path: it follows the desired twists exactly.
struct Path {
    pose: [f64; 3],
}

impl Path {
    fn new(pose: [f64; 3]) -> Self {
        Self { pose }
    }

    fn advance(&mut self, [v, w]: [f64; 2]) {
        let heading = self.pose[2] + w * COMMAND_PERIOD_S / 2.0;
        self.pose[0] += v * COMMAND_PERIOD_S * heading.cos();
        self.pose[1] += v * COMMAND_PERIOD_S * heading.sin();
        self.pose[2] += w * COMMAND_PERIOD_S;
    }
}

fn reference(
    path: &Path,
    message: Option<&LinkMessage>,
    desired: &DesiredTwists,
    k: usize,
    robot: usize,
) -> Reference {
    let speed = desired[k];
    match (robot, message) {
        (0, _) => Reference {
            pose: path.pose,
            speed,
        },
        (_, None) => Reference {
            pose: path.pose,
            speed: [0.0; 2],
        },
        (_, Some(message)) => {
            let (sin, cos) = message.yaw_rad.sin_cos();
            let pose = [
                message.x_m - SPACING_M * cos,
                message.y_m - SPACING_M * sin,
                message.yaw_rad,
            ];
            Reference { pose, speed }
        }
    }
}

/// The latest message that robot `i` has received by `t_s` (s).
fn latest(messages: &[LinkMessage], i: usize, t_s: f64) -> Option<&LinkMessage> {
    let name = Scene::name(i);
    let arrived = |message: &&LinkMessage| message.t_received_s.is_some_and(|at| at <= t_s);
    messages
        .iter()
        .rev()
        .filter(|message| *message.to == *name)
        .find(arrived)
}

fn send(
    scene: &Scene,
    robots: &[Robot],
    t_s: f64,
    random: &mut RandomStream,
    messages: &mut Vec<LinkMessage>,
) {
    for i in 1..robots.len() {
        let late = scene.robots[i]
            .concealed
            .iter()
            .filter(|effect| effect.effect == "link_delay");
        let late: f64 = late.flat_map(|effect| &effect.parameters).map(number).sum();
        let [x, y, yaw] = robots[i - 1].pose_at(t_s - late);
        let lost = random.bernoulli(0.02);
        let way_s = random.uniform(0.02, 0.045);
        messages.push(LinkMessage {
            t_sent_s: rounded(t_s),
            t_received_s: (!lost).then(|| rounded(t_s + way_s)),
            from: Arc::from(Scene::name(i - 1)),
            to: Arc::from(Scene::name(i)),
            x_m: rounded(x + random.normal(POSE_M)),
            y_m: rounded(y + random.normal(POSE_M)),
            yaw_rad: rounded(wrapped(yaw + random.normal(POSE_RAD))),
            v_m_s: f64::NAN,
            w_rad_s: f64::NAN,
        });
    }
}

fn number((_, value): &(String, slipstream_bus::Parameter)) -> f64 {
    match value {
        slipstream_bus::Parameter::Number(number) => *number,
        slipstream_bus::Parameter::Text(_) => 0.0,
    }
}
