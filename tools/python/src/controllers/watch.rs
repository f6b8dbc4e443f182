//! What binds the controllers of a run in this process to who started it.

use std::sync::{Arc, Mutex};

use pyo3::PyErr;

use crate::interruptible::Stop;

/// What binds the controllers of a run in this process to who started it.
#[derive(Clone, Default)]
pub(crate) struct Watch {
    /// The exception that ended the run.
    pub(crate) raised: Arc<Mutex<Option<PyErr>>>,
    /// Whether the run was given up.
    pub(crate) stop: Stop,
}
