//! The plant's part of a run: stepping the world through an experiment, reporting the ground truth,
//! and the plant's process.

mod changes;
mod lockstep;
mod observer;
#[cfg(feature = "process")]
pub mod process;
mod spacing;

pub use changes::Changes;
pub use lockstep::{Progress, lockstep};
pub use observer::{Observer, PlantReport, RobotReport};
pub use spacing::{SPACING_FROM_S, Spacing};

use slipstream_bus::{Experiment, InputError};

use crate::{Setup, World};

/// The world of an experiment at its start.
///
/// # Errors
/// An invalid robot model or sensor; the error's place begins with the robot's name.
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
