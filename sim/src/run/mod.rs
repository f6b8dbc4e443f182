//! The plant in a run: the world stepped through time, watched, and tied to the bus.

mod lockstep;
mod observer;
#[cfg(feature = "process")]
pub mod process;
mod spacing;

pub use lockstep::{Progress, lockstep};
pub use observer::{Observer, PlantReport, RobotReport};

use slipstream_bus::{Experiment, InputError};

use crate::{Setup, World};

/// The world of an experiment at its beginning.
///
/// # Errors
/// A robot model that cannot be simulated.
pub fn world(experiment: &Experiment) -> Result<World, InputError> {
    let setups: Vec<Setup> = experiment
        .robots
        .iter()
        .map(|robot| Setup {
            name: robot.name.clone(),
            model: robot.model.clone(),
            pose: robot.pose,
            sensors: experiment.settings.sensors.present(),
        })
        .collect();
    World::new(&setups, experiment.settings.seed)
}
