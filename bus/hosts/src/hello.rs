//! Joining: what a host says first, and what it is answered.

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use slipstream_bus::message::RobotIndex;

/// A host of a run other than the plant's, and the robots whose agents run there.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RemoteHost {
    /// Its name.
    pub name: String,
    /// The robots.
    pub robots: Vec<RobotIndex>,
}

/// The robots of these hosts.
pub(crate) fn robots_of(hosts: &[RemoteHost]) -> impl Iterator<Item = RobotIndex> {
    hosts.iter().flat_map(|host| host.robots.iter().copied())
}

/// What a host says first. It is read before the versions are compared, so it never changes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// Version and commit of its program.
    pub version: String,
    /// Its name.
    pub name: String,
}

/// The answer to a host that may join.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Welcome {
    /// Number of the run, drawn at its start.
    pub run: u64,
    /// The experiment (postcard).
    pub experiment: Vec<u8>,
    /// Its keys as TOML.
    pub keys: String,
    /// The robots whose agents the host runs.
    pub robots: Vec<RobotIndex>,
    /// The run is recorded.
    pub recording: bool,
}

impl FromStr for RemoteHost {
    type Err = String;

    /// Reads `NAME=ROBOT,…`, with robots counted from 0.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, robots) = text.split_once('=').ok_or("has no =")?;
        let robots: Result<Vec<RobotIndex>, _> = robots.split(',').map(str::parse).collect();
        let robots = robots.map_err(|error| error.to_string())?;
        Ok(Self {
            name: name.to_owned(),
            robots,
        })
    }
}

/// Whether a name can be that of a host: letters, digits, `-`, `_` and `.`.
pub fn is_host_name(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    !name.is_empty() && name.len() <= 64 && name.chars().all(allowed)
}
