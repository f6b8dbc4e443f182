//! Final reports of processes, as postcard files in the run directory.

use std::io::ErrorKind;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use slipstream_bus::transport::BusError;

/// Writes the report of the process `name`. The file is complete as soon as it has its final name.
///
/// # Errors
/// When it cannot be written, unless the launcher has already removed the directory.
pub fn write(folder: &Path, name: &str, report: &impl Serialize) -> Result<(), BusError> {
    let bytes = postcard::to_allocvec(report).map_err(|e| BusError::failed("report", e))?;
    let partial = folder.join(format!("report-{name}.partial"));
    match std::fs::write(&partial, bytes)
        .and_then(|()| std::fs::rename(&partial, folder.join(format!("report-{name}"))))
    {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        result => result.map_err(|e| BusError::failed("report", e)),
    }
}

/// Writes why the process `name` could not do its work.
///
/// # Errors
/// As [`write()`].
pub fn write_failure(folder: &Path, name: &str, reason: &str) -> Result<(), BusError> {
    write(folder, &failure_of(name), &reason)
}

/// Why the process `name` could not do its work, if it said so.
pub fn read_failure(folder: &Path, name: &str) -> Option<String> {
    read(folder, &failure_of(name))
}

fn failure_of(name: &str) -> String {
    format!("failure-{name}")
}

/// Reads the report of the process `name`; `None` if it ended without one.
pub fn read<T: DeserializeOwned>(folder: &Path, name: &str) -> Option<T> {
    let bytes = std::fs::read(folder.join(format!("report-{name}"))).ok()?;
    postcard::from_bytes(&bytes).ok()
}
