//! How a run is started, and why it could not be.

use std::path::PathBuf;

use slipstream_bus::InputError;
use slipstream_hosts::address::{Address, Security};
use slipstream_hosts::hello::RemoteHost;

/// How a run is started.
#[derive(Debug, Clone)]
pub struct Options {
    /// The program that plays the roles: this executable.
    pub program: PathBuf,
    /// The recording to write, if any.
    pub out: Option<PathBuf>,
    /// Draw a progress line on standard error.
    pub live: bool,
    /// Serve what is recorded to viewers, as it happens.
    pub serve: Option<Serve>,
    /// The other hosts, if the agents of some robots run on them.
    pub across: Option<Across>,
    /// `robots.toml`, if real robots take the place of the plant.
    pub real: Option<PathBuf>,
    /// Says what went wrong, as soon as it has.
    pub notice: fn(&str),
}

/// A run whose agents are on several hosts.
#[derive(Debug, Clone)]
pub struct Across {
    /// Where this host listens.
    pub address: Address,
    /// How the connections are protected.
    pub security: Security,
    /// The other hosts and their robots.
    pub hosts: Vec<RemoteHost>,
    /// Names of hosts that are started over ssh, each with the destination.
    pub ssh: Vec<(String, String)>,
}

/// How a run is served to viewers.
#[derive(Debug, Clone)]
pub struct Serve {
    /// Where it is listened, such as `127.0.0.1:8765`.
    pub address: String,
    /// The run begins once a viewer has subscribed.
    pub waits: bool,
}

/// Why a run could not be started.
#[derive(Debug, thiserror::Error)]
pub enum LaunchError {
    /// The input or the system does not meet the requirements.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The recording cannot be written.
    #[error(transparent)]
    Recording(#[from] slipstream_recording::Error),
    /// The operating system refused a step.
    #[error("failed to {step}: {error}")]
    System {
        /// The step.
        step: &'static str,
        /// The error of the operating system.
        error: std::io::Error,
    },
}
