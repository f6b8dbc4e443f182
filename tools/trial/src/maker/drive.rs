//! The scene plays: controllers, plants and wandering forces together.

use std::f64::consts::TAU;
use std::sync::Arc;

use slipstream_recording::recording::LinkMessage;

use super::chance::Chance;
use super::control::{Controller, Reference};
use super::manoeuvre::{HOLD_S, Wanted, open_loop, rounded, wanted};
use super::scene::{Control, Eye, Scene};
use super::sensors::{POSE_M, POSE_RAD, Sensors, looks, wrapped};
use super::trace::{KEEP_S, Trace};
use crate::plant::{Commands, Physics, Plant, State};

/// Robots of a platoon start this far behind each other (m).
const SPACING_M: f64 = 0.6;
/// Wandering forces change this often (s) and forget in this time (s).
const WANDER_S: f64 = 0.005;
const FORGET_S: f64 = 0.3;
/// Messages leave at every third command.
const MESSAGE_EVERY: usize = 3;

/// Streams of chance of one scene; robots have some each.
const STREAMS: u64 = 16;

/// What one robot did.
#[derive(Debug)]
pub(crate) struct Actor {
    /// What reached its wheels' drives.
    pub(crate) commands: Commands,
    pub(crate) trace: Trace,
    /// Of the encoders.
    pub(crate) phase: [f64; 2],
}

/// What a scene came to.
#[derive(Debug)]
pub(crate) struct Played {
    pub(crate) robots: Vec<Actor>,
    pub(crate) messages: Vec<LinkMessage>,
}

struct Robot {
    plant: Plant,
    state: State,
    commands: Commands,
    trace: Trace,
    controller: Option<Controller>,
    phase: [f64; 2],
    wander: Chance,
}

/// Plays a scene to its end.
///
/// # Errors
/// A model that cannot move.
pub(crate) fn play(scene: &Scene) -> Result<Played, String> {
    let nominal = Physics::new(&scene.nominal)?;
    let wanted = wanted(
        scene.style,
        scene.duration_s,
        &mut Chance::new(scene.seed, 1),
    );
    let mut robots: Vec<Robot> = (0..scene.robots.len())
        .map(|i| Robot::new(scene, i))
        .collect::<Result<_, _>>()?;
    let mut link = Chance::new(scene.seed, 2);
    let mut messages: Vec<LinkMessage> = Vec::new();
    let mut own = Path::new(robots.first().map_or([0.0; 3], |robot| robot.state.pose));
    for k in 0..wanted.len() {
        let t_s = k as f64 * HOLD_S;
        if scene.control == Control::Platoon && k % MESSAGE_EVERY == 0 {
            send(scene, &robots, t_s, &mut link, &mut messages);
        }
        for (i, robot) in robots.iter_mut().enumerate() {
            let told = match scene.control {
                Control::Open => open_loop(scene.told, &wanted, k, &nominal),
                Control::Closed | Control::Platoon => {
                    let heard = if i == 0 {
                        None
                    } else {
                        latest(&messages, i, t_s)
                    };
                    let reference = reference(&own, heard, &wanted, k, i);
                    robot.decide(k, &reference)
                }
            };
            robot.move_on(scene, k, told);
        }
        own.on(wanted[k]);
    }
    let ended = |robot: Robot| Actor {
        commands: robot.commands,
        trace: robot.trace,
        phase: robot.phase,
    };
    let robots = robots.into_iter().map(ended);
    Ok(Played {
        robots: robots.collect(),
        messages,
    })
}

impl Robot {
    fn new(scene: &Scene, i: usize) -> Result<Self, String> {
        let chance = |purpose: u64| Chance::new(scene.seed, STREAMS * (i as u64 + 1) + purpose);
        let physics = scene.physics(i)?;
        let eye = scene.robots[i].eye;
        let sensors = Sensors::new(&scene.model(i).effects, physics.grade);
        let looks = looks(
            scene.duration_s,
            [true, eye != Eye::Blind, scene.imu],
            &mut chance(1),
        );
        let mut phases = chance(2);
        let phase = [phases.unit(), phases.unit()];
        let quantity = scene.told.quantity();
        let plant = Plant::new(physics, quantity, scene.step_s);
        let mut place = Chance::new(scene.seed, 3);
        let yaw = place.between(-3.0, 3.0);
        let ahead = -SPACING_M * i as f64;
        let (x, y) = (place.between(-0.5, 0.5), place.between(-0.5, 0.5));
        let state = plant.start([x + ahead * yaw.cos(), y + ahead * yaw.sin(), yaw]);
        let mut trace = Trace::new(sensors, looks);
        trace.kept.push(state);
        trace.poses.push(state.pose);
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
            trace,
            controller: None,
            phase,
            wander: chance(3),
        };
        robot.controller =
            closed.then(|| Controller::new(state.pose, robot.counts(geometry[3]), geometry, limit));
        Ok(robot)
    }

    fn counts(&self, counts_per_rev: f64) -> [i64; 2] {
        let angles = self.trace.sensors.angles(&self.state);
        [0, 1].map(|i| (angles[i] * counts_per_rev / TAU + self.phase[i]).floor() as i64)
    }

    /// Where c was at a time that is past (s); before the start: where it stood.
    fn pose_at(&self, t_s: f64) -> [f64; 3] {
        let place = (t_s / HOLD_S).max(0.0);
        let poses = &self.trace.poses;
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

    /// Takes a command and moves until the next.
    fn move_on(&mut self, scene: &Scene, k: usize, told: [f64; 2]) {
        let (t_s, to_s) = (k as f64 * HOLD_S, (k + 1) as f64 * HOLD_S);
        let at_wheels = match scene.told {
            super::manoeuvre::Told::Twist => {
                Commands::wheel_speeds(told, self.plant.physics.nominal)
            }
            _ => told,
        };
        self.trace.told.push(told);
        self.commands.rows.push((t_s, at_wheels));
        let mut until_s = t_s;
        while until_s < to_s - 1e-9 {
            until_s = if scene.wandering_n > 0.0 {
                (until_s + WANDER_S).min(to_s)
            } else {
                to_s
            };
            self.wander(scene.wandering_n);
            let Self {
                plant,
                state,
                commands,
                trace,
                ..
            } = self;
            plant.advance(commands, state, until_s, |before, after| {
                trace.note(&plant.physics.strange, before, after);
            });
        }
        self.trace.poses.push(self.state.pose);
        if ((k + 1) as f64 * HOLD_S + 1e-9) % KEEP_S < 1e-6 {
            self.trace.kept.push(self.state);
        }
    }

    /// Ornstein and Uhlenbeck's process, exactly, over one change.
    fn wander(&mut self, deviation: f64) {
        if deviation > 0.0 {
            let left = (-WANDER_S / FORGET_S).exp();
            let fresh = (1.0 - left * left).sqrt();
            for (value, share) in self.state.disturbance.iter_mut().zip([1.0, 1.0, 0.1]) {
                *value = *value * left + self.wander.normal(deviation * share * fresh);
            }
        }
    }
}

/// The path that follows the wanted speeds exactly.
struct Path {
    pose: [f64; 3],
}

impl Path {
    fn new(pose: [f64; 3]) -> Self {
        Self { pose }
    }

    fn on(&mut self, [v, w]: [f64; 2]) {
        let heading = self.pose[2] + w * HOLD_S / 2.0;
        self.pose[0] += v * HOLD_S * heading.cos();
        self.pose[1] += v * HOLD_S * heading.sin();
        self.pose[2] += w * HOLD_S;
    }
}

fn reference(
    own: &Path,
    heard: Option<&LinkMessage>,
    wanted: &Wanted,
    k: usize,
    robot: usize,
) -> Reference {
    let speed = wanted[k];
    match (robot, heard) {
        (0, _) => Reference {
            pose: own.pose,
            speed,
        },
        (_, None) => Reference {
            pose: own.pose,
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

/// The newest message that robot `i` has by `t_s`.
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
    chance: &mut Chance,
    messages: &mut Vec<LinkMessage>,
) {
    for i in 1..robots.len() {
        let late = scene.robots[i]
            .hidden
            .iter()
            .filter(|effect| effect.effect == "link_delay");
        let late: f64 = late.flat_map(|effect| &effect.parameters).map(number).sum();
        let [x, y, yaw] = robots[i - 1].pose_at(t_s - late);
        let lost = chance.happens(0.02);
        let way_s = chance.between(0.02, 0.045);
        messages.push(LinkMessage {
            t_sent_s: rounded(t_s),
            t_received_s: (!lost).then(|| rounded(t_s + way_s)),
            from: Arc::from(Scene::name(i - 1)),
            to: Arc::from(Scene::name(i)),
            x_m: rounded(x + chance.normal(POSE_M)),
            y_m: rounded(y + chance.normal(POSE_M)),
            yaw_rad: rounded(wrapped(yaw + chance.normal(POSE_RAD))),
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
