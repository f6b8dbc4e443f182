//! What is known when a controller is made, for Python.

use pyo3::prelude::*;
use slipstream_agents::{AgentContext, ControllerError};
use slipstream_bus::message::robot_name;

/// What is known when a controller is made.
#[pyclass(module = "slipstream", frozen)]
pub(crate) struct Context {
    /// Name of the robot.
    #[pyo3(get)]
    robot: String,
    /// Names of all robots, from the front.
    #[pyo3(get)]
    robots: Vec<String>,
    /// Names of the robots that this one hears.
    #[pyo3(get)]
    hears: Vec<String>,
    settings: String,
}

impl Context {
    pub(crate) fn new(context: &AgentContext<'_>) -> Result<Self, ControllerError> {
        let settings = context.settings();
        Ok(Self {
            robot: context.name(),
            robots: (0..settings.robots.count).map(robot_name).collect(),
            hears: context.hears().into_iter().map(robot_name).collect(),
            settings: serde_json::to_string(settings).map_err(|error| error.to_string())?,
        })
    }
}

#[pymethods]
impl Context {
    /// Every key of the experiment, as nested dictionaries.
    #[getter]
    fn settings(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let json = py.import("json")?;
        Ok(json.call_method1("loads", (&self.settings,))?.unbind())
    }
}
