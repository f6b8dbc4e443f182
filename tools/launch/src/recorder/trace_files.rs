//! Trace records outside of the record stream: processes leave what they traced before they were
//! connected, or after they disconnected, as files in the run directory.

use std::fs;
use std::path::{Path, PathBuf};

use slipstream_bus::{Experiment, InputError};
use slipstream_ipc::run_directory::RunDirectory;
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

/// Prefix of the file names.
const PREFIX: &str = "trace-";

/// Saves the buffered trace of this thread for the recorder, as `name`.
pub(crate) fn save_trace(folder: &Path, name: &str) {
    let bytes = trace::take_buffer();
    // If the directory is gone, the run is over and nobody reads the file.
    if !bytes.is_empty() {
        let _ = fs::write(folder.join(format!("{PREFIX}{name}")), bytes);
    }
}

/// The saved traces, sorted by name.
pub(crate) fn read_traces(directory: &RunDirectory) -> Vec<Vec<u8>> {
    let Ok(entries) = fs::read_dir(directory.folder()) else {
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| {
        let name = path.file_name().unwrap_or_default();
        name.to_string_lossy().starts_with(PREFIX)
    });
    paths.sort();
    paths.iter().flat_map(fs::read).collect()
}
