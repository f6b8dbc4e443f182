//! Simulates a scene: controllers, plants and random disturbances.

use slipstream_recording::recording::LinkMessage;
use slipstream_trial_plant::{Commands, Physics};

use super::manoeuvre::{COMMAND_PERIOD_S, DesiredTwists, desired_twists, open_loop};
use super::platoon_link::{latest, send};
use super::random::RandomStream;
use super::reference::{Path, Reference};
use super::robot::Robot;
use super::scene::{Control, Scene, Start};
use super::truth::Truth;

/// Number of commands from one message to the next.
const MESSAGE_EVERY: usize = 3;
/// Least speed of a recording that starts in motion (m/s), and in how much of the manoeuvre it is looked for
/// (s).
const START_M_S: f64 = 0.25;
const SEARCH_S: f64 = 20.0;

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

/// The desired twists of a scene, in agreement with how it starts.
fn desired(scene: &Scene) -> DesiredTwists {
    let mut random = RandomStream::new(scene.seed, 1);
    let rows = |duration_s: f64| (duration_s / COMMAND_PERIOD_S).round() as usize;
    match scene.start {
        Start::Rest => desired_twists(scene.style, scene.duration_s, &mut random),
        Start::Pressing { for_s, .. } => {
            let later = desired_twists(scene.style, scene.duration_s - for_s, &mut random);
            let mut desired = vec![[0.0; 2]; rows(scene.duration_s) - later.len()];
            desired.extend(later);
            desired
        }
        Start::Moving | Start::Sliding { .. } => {
            let longer = desired_twists(scene.style, scene.duration_s + SEARCH_S, &mut random);
            let wanted = rows(scene.duration_s);
            let last = longer.len() - wanted;
            let moves = |k: &usize| longer[*k][0] > START_M_S;
            let from = (0..last).find(moves).unwrap_or(last);
            longer[from..from + wanted].to_vec()
        }
    }
}

/// Simulates a scene.
///
/// # Errors
/// A model that cannot be simulated.
pub(crate) fn simulate(scene: &Scene) -> Result<SimulatedScene, String> {
    let nominal = Physics::new(&scene.nominal)?;
    let desired = desired(scene);
    let first = desired.first().copied().unwrap_or([0.0; 2]);
    let mut robots: Vec<Robot> = (0..scene.robots.len())
        .map(|i| Robot::new(scene, i, first))
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
                Control::Open => match scene.start {
                    Start::Pressing { command, for_s } if t_s < for_s => [command; 2],
                    _ => open_loop(scene.command_kind, &desired, k, &nominal),
                },
                Control::Closed | Control::Platoon if i == 0 => {
                    robot.decide(k, &Reference::on_path(&path, desired[k]))
                }
                Control::Closed | Control::Platoon => {
                    let message = latest(&messages, i, t_s);
                    robot.decide(k, &Reference::behind(message, &path, desired[k]))
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
