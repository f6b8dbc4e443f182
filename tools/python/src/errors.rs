//! Exceptions: what the user gave cannot be used, or the work failed.

use std::fmt::Display;

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    slipstream,
    InputError,
    PyValueError,
    "What was given cannot be used: `place`, `problem` and `remedy` say where, what and what to do."
);
create_exception!(slipstream, Failed, PyRuntimeError, "The work failed.");

/// Unusable input as an exception with place and remedy.
pub(crate) fn input(py: Python<'_>, error: &slipstream_bus::InputError) -> PyErr {
    let raised = InputError::new_err(error.to_string());
    let value = raised.value(py);
    for (name, text) in [
        ("place", &error.place),
        ("problem", &error.problem),
        ("remedy", &error.remedy),
    ] {
        // an exception without its details is still one
        let _ = value.setattr(name, text);
    }
    raised
}

/// An error of a recording.
pub(crate) fn of_recording(py: Python<'_>, error: slipstream_recording::Error) -> PyErr {
    match error {
        slipstream_recording::Error::Input(error) => input(py, &error),
        other => failed(&other),
    }
}

/// Failed work.
pub(crate) fn failed(error: &impl Display) -> PyErr {
    Failed::new_err(error.to_string())
}
