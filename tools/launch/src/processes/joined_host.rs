//! The part of a host that has joined the run of another.

use std::ffi::OsString;
use std::path::PathBuf;

use slipstream_bus::message::RobotIndex;
use slipstream_hosts::address::{Address, Security};

use crate::program::Programs;

/// The name under which the launcher of such a host leaves why it stopped its agents.
pub(super) const HOST: &str = "host";

/// The part of a host that has joined the run of another.
#[derive(Debug, Clone)]
pub(super) struct JoinedHost {
    pub(super) program: PathBuf,
    /// Where the plant's host listens.
    pub(super) address: Address,
    pub(super) security: Security,
    /// The name of this host.
    pub(super) name: String,
    /// Number of the run.
    pub(super) run: u64,
    /// The robots of this host.
    pub(super) robots: Vec<RobotIndex>,
    /// Programs of their agents in place of the built-in controller.
    pub(super) programs: Programs,
    pub(super) recording: bool,
    pub(super) live: bool,
    pub(super) notice: fn(&str),
}

impl JoinedHost {
    /// Arguments of the relay alone.
    pub(super) fn relay_arguments(&self) -> Vec<OsString> {
        let mut arguments: Vec<OsString> = vec![
            "--address".into(),
            self.address.to_string().into(),
            "--name".into(),
            OsString::from(&self.name),
            "--number".into(),
            self.run.to_string().into(),
        ];
        arguments.extend(self.security.arguments());
        arguments
    }
}
