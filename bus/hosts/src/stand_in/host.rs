//! One other host, as the stand-in knows it.

use std::time::{Duration, Instant};

use slipstream_bus::message::RobotIndex;
use slipstream_bus::transport::BusError;

use crate::clock::ClockReport;
use crate::frame::{AgentState, Answer, Report, Sent};
use crate::hello::RemoteHost;
use crate::timing::Contact;

/// Time that the last frame of a host whose process is gone has to arrive.
const GONE_GRACE: Duration = Duration::from_millis(200);

/// One other host.
pub(super) struct Host {
    pub(super) remote: RemoteHost,
    pub(super) stage: Stage,
    pub(super) contact: Contact,
    /// When its process was found to be gone.
    pub(super) gone: Option<Instant>,
    /// The frame that it has not answered yet, and when it was sent.
    pub(super) asked: Option<(Vec<u8>, Instant)>,
    pub(super) answer: Option<Answer>,
    pub(super) report: Option<Report>,
    /// Number of the last batch of records that has arrived.
    pub(super) kept: u64,
}

/// How far a host has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Stage {
    /// It has not joined.
    Absent,
    /// It has joined and starts its agents.
    Joined,
    /// Its agents are connected.
    Ready,
    /// It has reported what its agents left.
    Reported,
    /// It knows that this has arrived, or is gone after it.
    Left,
    /// It is given up, and the run goes on without it.
    Lost,
}

/// On the wall clock: what has come from a host.
pub(super) enum Arrived {
    /// Torques and positions.
    Sent(Sent),
    /// Chunks of records.
    Records(Vec<Vec<u8>>),
    /// What is known of its clock.
    Clock(ClockReport),
    /// Its agents.
    Agents(Vec<AgentState>),
    /// Nothing any more: the host is lost, for this reason.
    Lost(String),
}

impl Host {
    pub(super) fn new(remote: &RemoteHost) -> Self {
        Self {
            remote: remote.clone(),
            stage: Stage::Absent,
            contact: Contact::now(),
            gone: None,
            asked: None,
            answer: None,
            report: None,
            kept: 0,
        }
    }

    pub(super) fn failed(&self, reason: &str) -> BusError {
        BusError::Failed {
            what: format!("host {}", self.remote.name),
            reason: reason.to_owned(),
        }
    }

    /// Why the host can no longer be waited for, if so.
    pub(super) fn problem(&self, timeout: Duration) -> Option<String> {
        if self.stage >= Stage::Reported {
            return None;
        }
        if self.gone.is_some_and(|since| since.elapsed() > GONE_GRACE) {
            return Some("its process is gone: killed, or its computer is down".to_owned());
        }
        self.contact.too_silent(timeout)
    }

    /// Checks that an answer is about the robots of the host and no others.
    pub(super) fn check(&self, answer: &Answer) -> Result<(), BusError> {
        let mut answered: Vec<RobotIndex> = answer.commands.iter().map(|own| own.robot).collect();
        answered.sort_unstable();
        let mut expected = self.remote.robots.clone();
        expected.sort_unstable();
        if answered != expected {
            return Err(self.foreign());
        }
        self.check_senders(answer.positions.iter().map(|position| position.from))
    }

    /// Checks that everything sent is from robots of the host.
    pub(super) fn check_sent(&self, sent: &Sent) -> Result<(), BusError> {
        let commands = sent.commands.iter().map(|command| command.robot);
        let positions = sent.positions.iter().map(|position| position.from);
        self.check_senders(commands.chain(positions))
    }

    fn check_senders(&self, mut senders: impl Iterator<Item = RobotIndex>) -> Result<(), BusError> {
        match senders.all(|robot| self.remote.robots.contains(&robot)) {
            true => Ok(()),
            false => Err(self.foreign()),
        }
    }

    fn foreign(&self) -> BusError {
        self.failed("it answers for other robots than its own")
    }
}
