//! Begin of the trace of the launcher, or of a run in one process.

use slipstream_bus::{Experiment, InputError};
use slipstream_ipc::trace::{self, Tracing};

/// Starts the trace of this thread as `process`, if the recording is to hold one.
///
/// # Errors
/// An invalid filter in the environment.
pub(crate) fn begin(experiment: &Experiment, process: &str) -> Result<Option<Tracing>, InputError> {
    if !experiment.settings.recording.trace {
        return Ok(None);
    }
    match trace::filter() {
        Ok(filter) => Ok(Some(trace::begin(process, filter))),
        Err(problem) => {
            let remedy = "set it to a filter such as slipstream=debug, or unset it";
            Err(InputError::new(trace::VARIABLE, problem, remedy))
        }
    }
}
