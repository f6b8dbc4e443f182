//! Description of a program's controller, before a run: its parameters, or why there can be no such controller.

use std::path::Path;

use serde::{Deserialize, Serialize};
use slipstream_bus::experiment::{Experiment, Parameters};
use slipstream_bus::message::RobotIndex;
use slipstream_ipc::part::PROTOCOL;

use crate::controller::{AgentContext, Controller, ControllerError};
use crate::node::Node;

/// What a program says of its controller, as JSON.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Description {
    /// [`PROTOCOL`] of the program.
    pub protocol: String,
    /// The controller's parameters with their values in this experiment.
    #[serde(default)]
    pub parameters: Parameters,
    /// Why the controller cannot be made.
    #[serde(default)]
    pub problem: Option<Problem>,
}

/// Why a controller cannot be made.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Problem {
    /// The key that is to blame; empty if none is.
    pub place: String,
    /// What is wrong.
    pub problem: String,
    /// How to fix it; empty if the program does not say.
    pub remedy: String,
}

impl Description {
    /// Name of its file.
    pub const FILE: &str = "description.json";
    /// Name of the file with the experiment (postcard).
    pub const EXPERIMENT: &str = "experiment";

    /// The description of a controller that cannot be made.
    pub fn of_problem(error: &ControllerError) -> Self {
        let problem = match error {
            ControllerError::Input(error) => Problem {
                place: error.place.clone(),
                problem: error.problem.clone(),
                remedy: error.remedy.clone(),
            },
            ControllerError::Failed(reason) => Problem {
                problem: reason.clone(),
                ..Problem::default()
            },
        };
        Self {
            protocol: PROTOCOL.to_owned(),
            problem: Some(problem),
            ..Self::default()
        }
    }
}

/// Describes the controller that `make` makes for a robot of the experiment in `folder`.
pub(super) fn describe<C: Controller>(
    folder: &Path,
    robot: RobotIndex,
    make: impl FnOnce(&AgentContext<'_>) -> Result<C, ControllerError>,
) -> Description {
    let described = read_experiment(folder).and_then(|experiment| {
        let context = AgentContext::new(&experiment, robot)?;
        let controller = make(&context)?;
        let parameters = context.declared()?;
        Node::with(&experiment, robot, controller)?;
        Ok(parameters)
    });
    match described {
        Ok(parameters) => Description {
            protocol: PROTOCOL.to_owned(),
            parameters,
            problem: None,
        },
        Err(error) => Description::of_problem(&error),
    }
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
