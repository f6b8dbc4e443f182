//! Files that the launcher writes into the run directory for the other processes.

use std::path::Path;
use std::{fs, io};

use slipstream_bus::Experiment;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::services::iox2_config;

/// Writes the experiment for the processes (postcard), its keys for the recording (TOML), and the
/// configuration with which the `iox2` tool sees the run.
pub(crate) fn write(
    directory: &RunDirectory,
    experiment: &Experiment,
    keys: &str,
) -> io::Result<()> {
    let bytes = postcard::to_allocvec(experiment).map_err(io::Error::other)?;
    fs::write(directory.experiment(), bytes)?;
    fs::write(directory.folder().join("experiment.toml"), keys)?;
    let config = directory.folder().join("config");
    fs::create_dir(&config)?;
    fs::write(config.join("iceoryx2.toml"), iox2_config(directory))
}

/// The resolved keys as TOML; empty if the file is missing.
pub(crate) fn read_keys(folder: &Path) -> String {
    fs::read_to_string(folder.join("experiment.toml")).unwrap_or_default()
}
