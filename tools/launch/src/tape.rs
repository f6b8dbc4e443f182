//! The trace of what is told outside of the bus, and its filter.

use std::fs;
use std::path::{Path, PathBuf};

use slipstream_bus::Experiment;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::trace::{self, Tracing};

use slipstream_bus::InputError;

/// Begins the trace of this thread as `process`, if the experiment's recording is to hold one.
///
/// # Errors
/// A filter in the environment that is none.
pub(crate) fn begin(experiment: &Experiment, process: &str) -> Result<Option<Tracing>, InputError> {
    if !experiment.settings.recording.trace {
        return Ok(None);
    }
    match trace::filter() {
        Ok(filter) => Ok(Some(trace::begin(process, filter))),
        Err(problem) => {
            let remedy = "give such as RUST_LOG=slipstream=debug, or none";
            Err(InputError::new(trace::VARIABLE, problem, remedy))
        }
    }
}

/// How the files of tapes begin.
const TAPE: &str = "trace-";

/// Leaves what the thread's trace has told and nobody took in for the recorder, as `name`.
pub(crate) fn leave_tape(folder: &Path, name: &str) {
    let tape = trace::take_buffer();
    // Without the folder the run is over and nobody reads it.
    if !tape.is_empty() {
        let _ = fs::write(folder.join(format!("{TAPE}{name}")), tape);
    }
}

/// The tapes that were left, by their names.
pub(crate) fn read_tapes(place: &RunDirectory) -> Vec<Vec<u8>> {
    let Ok(entries) = fs::read_dir(place.folder()) else {
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| {
        let name = path.file_name().unwrap_or_default();
        name.to_string_lossy().starts_with(TAPE)
    });
    paths.sort();
    paths.iter().flat_map(fs::read).collect()
}
