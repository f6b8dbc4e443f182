//! Controllers in Python: agents as programs of their own, and controllers of a run in this process.

mod context;
mod controller;
mod input;
mod watch;

use std::ffi::OsString;

use pyo3::prelude::*;
use slipstream_agents::process::run_agent_with;

pub(crate) use self::context::Context;
pub(crate) use self::controller::PythonController;
pub(crate) use self::input::{Heard, InnerInput, OuterInput};
pub(crate) use self::watch::Watch;

/// Runs the agent that the arguments name, with the controller that `make` makes; returns the exit code of the program.
#[pyfunction]
pub(crate) fn run_agent(py: Python<'_>, arguments: Vec<OsString>, make: Py<PyAny>) -> u8 {
    py.detach(|| {
        run_agent_with(&arguments, |context| {
            PythonController::new(&make, context, None)
        })
    })
}
