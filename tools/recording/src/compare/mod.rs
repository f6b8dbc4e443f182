//! `slipstream compare`: the simulation of the recorded commands next to the recording, or two recordings of one
//! experiment next to each other (`two_runs`).
//!
//! The simulation runs open loop from the first command to the last row. Only its start pose is
//! fitted, to the poses of the first half second. Without commands, the wheel speeds drive it.

mod channel;
mod commands;
mod overlay;
mod simulation;
mod start;
pub mod two_runs;
mod wheel_angles;

use slipstream_bus::{InputError, RobotModel};
use slipstream_sim::Robot as Plant;

pub use channel::{Channel, interpolate};

use crate::mended::mended;
use crate::recording::Recording;

/// Why a recording cannot be compared with a simulation.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// There is no model for this robot.
    #[error("no model for {0}; give one with --robot")]
    NoModel(String),
    /// The simulation rejects the model of a robot.
    #[error("the model of {robot}: {source}")]
    Model {
        /// The robot.
        robot: String,
        /// What is wrong with its model.
        source: InputError,
    },
    /// There are no inputs for a simulation.
    #[error(
        "no robot has two rows in command.csv or wheels.csv; record the commands to the drives"
    )]
    NothingToSimulate,
}

/// Simulates every robot with recorded commands or wheels. Returns each recorded quantity with its
/// simulation, in the order of the robots.
///
/// `model_of` gives the model of each robot; without one, the model that came with the recording is
/// used.
///
/// # Errors
/// If a robot has no model or one that the simulation rejects, or if no robot has inputs for a
/// simulation.
pub fn compare(
    recording: &Recording,
    model_of: impl Fn(&str) -> Option<RobotModel>,
) -> Result<Vec<Channel>, CompareError> {
    let (recording, _) = mended(recording, &model_of);
    let mut channels = Vec::new();
    for robot in &recording.robots {
        let Some(model) = model_of(&robot.name).or_else(|| recording.model.clone()) else {
            return Err(CompareError::NoModel(robot.name.clone()));
        };
        if let Some(commands) = commands::commands(robot, &model) {
            let rejected = |source| CompareError::Model {
                robot: robot.name.clone(),
                source,
            };
            let plant = Plant::new(&model).map_err(rejected)?;
            plant.accepts(commands::kind(&commands)).map_err(rejected)?;
            let start = start::fit_start_pose(&plant, robot, &model, &commands);
            let samples = simulation::simulate(&plant, robot, start, &commands, f64::INFINITY);
            channels.extend(overlay::channels(robot, &model, &samples));
        }
    }
    if channels.is_empty() {
        return Err(CompareError::NothingToSimulate);
    }
    Ok(channels)
}
