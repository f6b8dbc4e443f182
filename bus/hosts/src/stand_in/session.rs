//! A session of the stand-in: the run that it has joined, and what goes wrong on other hosts although it goes on.

use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::services::Services;

use crate::hello::RemoteHost;

/// The run that the stand-in has joined.
pub(super) struct Session<'a> {
    pub(super) joined: &'a JoinedRun,
    pub(super) services: &'a Services,
    /// The other hosts.
    pub(super) hosts: &'a [RemoteHost],
    /// The run is recorded.
    pub(super) recording: bool,
    /// Says something to the user.
    pub(super) notice: &'a dyn Fn(&str),
    /// On the wall clock: time 0 of the run on the clock of this host (ns).
    pub(super) start_ns: i64,
    /// What went wrong although the run went on.
    pub(super) failures: Vec<String>,
}

impl Session<'_> {
    /// Says what went wrong on a host although the run goes on, and keeps it. `follows`: the end of the sentence.
    pub(super) fn fail(&mut self, host: &str, reason: &str, follows: &str) {
        let failure = format!("host {host}: {reason}");
        (self.notice)(&format!("{failure}{follows}"));
        self.failures.push(failure);
    }
}
