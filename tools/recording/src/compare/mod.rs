//! `slipstream compare`: the simulation of the recorded commands beside the recording.
//!
//! Open loop from the first command to the last row. Only where it starts is fitted, to the poses
//! of the first half second. Where no command was recorded, the wheels drive the simulation.

mod channel;
mod commands;
mod overlay;
mod sensors;
mod simulation;
mod start;

use slipstream_bus::{ModelError, RobotModel};
use slipstream_sim::Robot as Plant;

pub use channel::Channel;

use crate::recording::Recording;
use commands::{commands, kind};
use overlay::of_robot;
use simulation::simulate;
use start::fit_start;

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
        source: ModelError,
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
