//! Description of a program's controller, before a run: its parameters, or why there can be no such controller.

use std::path::Path;

use serde::{Deserialize, Serialize};
use slipstream_bus::experiment::{Experiment, Parameters};
use slipstream_bus::message::RobotIndex;
use slipstream_ipc::part::PROTOCOL;

use crate::controller::{AgentContext, Controller, ControllerError};
use crate::node::Node;

/// What a program says of its controller, as JSON.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// [`PROTOCOL`] of the program.
    pub protocol: String,
    /// The controller's parameters with their values in this experiment, or why the controller cannot be made.
    pub parameters: Result<Parameters, ControllerError>,
}

impl Description {
    /// Name of its file.
    pub const FILE: &str = "description.json";
    /// Name of the file with the experiment (postcard).
    pub const EXPERIMENT: &str = "experiment";

    /// The description by this version.
    pub(super) fn new(parameters: Result<Parameters, ControllerError>) -> Self {
        let protocol = PROTOCOL.to_owned();
        Self {
            protocol,
            parameters,
        }
    }
}

/// The parameters of the controller that `make` makes for a robot of the experiment in `folder`.
pub(super) fn describe<C: Controller>(
    folder: &Path,
    robot: RobotIndex,
    make: impl FnOnce(&AgentContext<'_>) -> Result<C, ControllerError>,
) -> Result<Parameters, ControllerError> {
    let experiment = read_experiment(folder)?;
    Ok(Node::made(&experiment, robot, make)?.1)
}

fn read_experiment(folder: &Path) -> Result<Experiment, ControllerError> {
    let bytes = std::fs::read(folder.join(Description::EXPERIMENT));
    let bytes = bytes.map_err(|error| format!("the experiment cannot be read: {error}"))?;
    postcard::from_bytes(&bytes)
        .map_err(|error| format!("the experiment cannot be read: {error}").into())
}

/// Writes a description. The file is complete as soon as it has its name.
pub(super) fn write(folder: &Path, description: &Description) -> std::io::Result<()> {
    let partial = folder.join("description.partial");
    std::fs::write(&partial, serde_json::to_vec(description)?)?;
    std::fs::rename(&partial, folder.join(Description::FILE))
}
