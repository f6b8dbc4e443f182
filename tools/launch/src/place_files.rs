//! The files of a run's folder that the launcher writes for the others.

use std::fs;
use std::io;

use slipstream_bus::Experiment;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::services::iox2_config;

/// Writes the description for the processes, the keys for the recording, and what `iox2` needs to
/// see the run.
pub(crate) fn write(place: &RunDirectory, experiment: &Experiment, keys: &str) -> io::Result<()> {
    let bytes = postcard::to_allocvec(experiment).map_err(io::Error::other)?;
    fs::write(place.experiment(), bytes)?;
    fs::write(place.folder().join("experiment.toml"), keys)?;
    let config = place.folder().join("config");
    fs::create_dir(&config)?;
    fs::write(config.join("iceoryx2.toml"), iox2_config(place))
}

/// The experiment as it was resolved, as TOML; empty where it is not there.
pub(crate) fn read_keys(place: &RunDirectory) -> String {
    fs::read_to_string(place.folder().join("experiment.toml")).unwrap_or_default()
}
