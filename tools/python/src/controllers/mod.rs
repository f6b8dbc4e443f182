//! Controllers in Python: agents as programs of their own, and controllers of a run in this process.

mod context;
mod controller;
mod input;

use std::ffi::OsString;
use std::sync::{Arc, Mutex};

use pyo3::prelude::*;
use slipstream_agents::process::run_agent_with;

use crate::interruptible::Stop;

pub(crate) use self::context::Context;
pub(crate) use self::controller::PythonController;
pub(crate) use self::input::{Heard, InnerInput, OuterInput};

/// What binds the controllers of a run in this process to who started it.
#[derive(Clone, Default)]
pub(crate) struct Watch {
    /// The exception that ended the run.
    pub(crate) raised: Arc<Mutex<Option<PyErr>>>,
    /// Whether the run was given up.
    pub(crate) stop: Stop,
}

/// Runs the agent that the arguments name, with the controller that `make` makes; returns the exit code of the program.
#[pyfunction]
pub(crate) fn run_agent(py: Python<'_>, arguments: Vec<OsString>, make: Py<PyAny>) -> u8 {
    py.detach(|| {
        run_agent_with(&arguments, |context| {
            PythonController::new(&make, context, None)
        })
    })
}
