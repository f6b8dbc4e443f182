//! Trace records outside of the record stream: processes leave what they traced before they were connected, or after they
//! disconnected, as files in the run directory.

use std::fs;
use std::path::{Path, PathBuf};

use crate::run_directory::RunDirectory;

/// Prefix of the file names.
const PREFIX: &str = "trace-";

/// Saves a part of the trace for the recorder, as `name`.
pub(super) fn write(folder: &Path, name: &str, bytes: &[u8]) {
    // If the directory is gone, the run is over and nobody reads the file.
    if !bytes.is_empty() {
        let _ = fs::write(folder.join(format!("{PREFIX}{name}")), bytes);
    }
}

/// The saved traces, sorted by name.
pub fn read_saved(directory: &RunDirectory) -> Vec<Vec<u8>> {
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
