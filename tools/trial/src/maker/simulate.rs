//! Simulates a scene: controllers, plants and random disturbances.

use slipstream_recording::recording::LinkMessage;
use slipstream_trial_plant::{Commands, Physics};

use super::manoeuvre::{COMMAND_PERIOD_S, desired_twists, open_loop};
use super::platoon_link::{latest, send};
use super::random::RandomStream;
use super::reference::{Path, Reference};
use super::robot::Robot;
use super::scene::{Control, Scene};
use super::truth::Truth;

/// Number of commands from one message to the next.
const MESSAGE_EVERY: usize = 3;

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
