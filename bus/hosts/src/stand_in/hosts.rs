//! The other hosts, as the stand-in hears them: who has joined, who has answered, who is silent.

use std::time::{Duration, Instant};

use serde::Serialize;
use slipstream_bus::message::RobotIndex;
use slipstream_bus::transport::BusError;
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::presence::Presence;

use crate::carrier::{Event, PlantCarrier};
use crate::frame::{Answer, Down, Report, Up, decode, encode};
use crate::hello::{Hello, RemoteHost, Welcome};
use crate::timing::{Contact, POLL_INTERVAL, RESEND};

/// Time that the last frame of a host whose process is gone has to arrive.
const GONE_GRACE: Duration = Duration::from_millis(200);

/// All other hosts and the network to them.
pub(super) struct Hosts<'a> {
    carrier: &'a mut dyn PlantCarrier,
    presence: Presence,
    version: &'a str,
    notice: &'a dyn Fn(&str),
    /// What a host is told when it joins, but for its robots.
    welcome: Welcome,
    timeout: Duration,
    hosts: Vec<Host>,
}

/// One other host.
struct Host {
    remote: RemoteHost,
    stage: Stage,
    contact: Contact,
    /// When its process was found to be gone.
    gone: Option<Instant>,
    /// The frame that it has not answered yet, and when it was sent.
    asked: Option<(Vec<u8>, Instant)>,
    answer: Option<Answer>,
    report: Option<Report>,
}

/// How far a host has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Stage {
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
}

impl<'a> Hosts<'a> {
    /// Nobody has joined yet.
    pub(super) fn new(
        remote: &[RemoteHost],
        joined: &JoinedRun,
        version: &'a str,
        notice: &'a dyn Fn(&str),
        welcome: Welcome,
        carrier: &'a mut dyn PlantCarrier,
    ) -> Self {
        let host = |remote: &RemoteHost| Host {
            remote: remote.clone(),
            stage: Stage::Absent,
            contact: Contact::now(),
            gone: None,
            asked: None,
            answer: None,
            report: None,
        };
        Self {
            carrier,
            presence: joined.presence.clone(),
            version,
            notice,
            welcome,
            timeout: Duration::from_secs_f64(joined.experiment.settings.host_timeout_s),
            hosts: remote.iter().map(host).collect(),
        }
    }

    /// Waits until the agents of all hosts are connected.
    pub(super) fn await_all(&mut self) -> Result<(), BusError> {
        while self.hosts.iter().any(|host| host.stage < Stage::Ready) {
            self.receive(POLL_INTERVAL)?;
            self.beat()?;
            for host in &mut self.hosts {
                // It may try again: nothing has begun.
                if host.gone.is_some() || host.contact.silence() > self.timeout {
                    (host.stage, host.gone) = (Stage::Absent, None);
                }
            }
            self.presence.check()?;
        }
        Ok(())
    }

    /// Sends every host a frame for its robots, which it has to answer.
    pub(super) fn ask(&mut self, frame: impl Fn(&[RobotIndex]) -> Down) -> Result<(), BusError> {
        for host in &mut self.hosts {
            let bytes = encode(&frame(&host.remote.robots))?;
            self.carrier.send(&host.remote.name, &bytes)?;
            host.contact.sent();
            host.answer = None;
            host.asked = Some((bytes, Instant::now()));
        }
        Ok(())
    }

    /// Waits until all hosts have answered the round. Returns their robots and answers.
    pub(super) fn await_answers(
        &mut self,
        number: u64,
    ) -> Result<Vec<(Vec<RobotIndex>, Answer)>, BusError> {
        let answered = |host: &Host| matches!(&host.answer, Some(own) if own.number == number);
        while !self.hosts.iter().all(answered) {
            self.receive(POLL_INTERVAL)?;
            self.ask_again()?;
            self.check()?;
        }
        let answers = self.hosts.iter_mut().filter_map(|host| {
            host.asked = None;
            Some((host.remote.robots.clone(), host.answer.take()?))
        });
        Ok(answers.collect())
    }

    /// Whether all hosts have reported what their agents left, and know that it has arrived or are silent since.
    pub(super) fn all_have_left(&self) -> bool {
        let left = |host: &Host| match host.stage {
            Stage::Reported => host.contact.silence() > self.timeout,
            stage => stage == Stage::Left,
        };
        self.hosts.iter().all(left)
    }

    /// Waits for reports for a moment. Returns those that came. `stopped`: the run ends early, and nobody has to
    /// report any more.
    pub(super) fn take_reports(
        &mut self,
        stopped: bool,
    ) -> Result<Vec<(RemoteHost, Report)>, BusError> {
        self.receive(POLL_INTERVAL)?;
        self.ask_again()?;
        if !stopped {
            self.check()?;
        }
        let mut reports = Vec::new();
        for host in &mut self.hosts {
            if let Some(report) = host.report.take() {
                reports.push((host.remote.clone(), report));
            }
        }
        Ok(reports)
    }

    /// Looks what has come, without waiting.
    pub(super) fn look(&mut self) -> Result<(), BusError> {
        self.receive(Duration::ZERO)?;
        self.beat()?;
        self.check()
    }

    /// Tells all hosts that the run ends early.
    pub(super) fn stop(&mut self, reason: &str) {
        if let Ok(bytes) = encode(&Down::Stop(reason.to_owned())) {
            for host in &self.hosts {
                let _ = self.carrier.send(&host.remote.name, &bytes);
            }
        }
    }

    /// Handles what has come, after waiting for it at most for `timeout`.
    fn receive(&mut self, mut timeout: Duration) -> Result<(), BusError> {
        while let Some(event) = self.carrier.receive(timeout)? {
            timeout = Duration::ZERO;
            match event {
                Event::Hello { hello, answer } => match self.greet(&hello) {
                    Ok(welcome) => answer(Ok(&welcome)),
                    Err(refusal) => {
                        (self.notice)(&format!("refused a host that asked to join: {refusal}"));
                        answer(Err(&refusal));
                    }
                },
                Event::Frame { host, bytes } => self.take_frame(&host, &bytes)?,
                Event::Gone { host } => {
                    if let Some(host) = find(&mut self.hosts, &host) {
                        match host.stage {
                            Stage::Reported => host.stage = Stage::Left,
                            _ => host.gone = Some(Instant::now()),
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The answer to a host that asks to join, or why it may not.
    fn greet(&mut self, hello: &[u8]) -> Result<Vec<u8>, String> {
        let Hello { version, name } =
            decode(hello).map_err(|_| "it is no slipstream that this one knows".to_owned())?;
        if version != self.version {
            let own = self.version;
            return Err(format!(
                "this is slipstream {version}, and the run is of slipstream {own}: use the same build on both hosts"
            ));
        }
        let names: Vec<&str> = self.hosts.iter().map(|host| &*host.remote.name).collect();
        let names = names.join(", ");
        let Some(host) = find(&mut self.hosts, &name) else {
            return Err(format!("the run waits for no host {name}, but for {names}"));
        };
        if host.stage > Stage::Absent {
            return Err(format!("a host {name} has joined already"));
        }
        let welcome = Welcome {
            robots: host.remote.robots.clone(),
            ..self.welcome.clone()
        };
        let bytes = encode(&welcome).map_err(|error| error.to_string())?;
        host.stage = Stage::Joined;
        host.contact = Contact::now();
        Ok(bytes)
    }

    fn take_frame(&mut self, name: &str, bytes: &[u8]) -> Result<(), BusError> {
        let Some(host) = find(&mut self.hosts, name) else {
            return Ok(());
        };
        let frame = decode(bytes).map_err(|error| host.failed(&error.to_string()))?;
        host.contact.heard();
        host.gone = None;
        let reply = match frame {
            Up::Ready(run) if run != self.welcome.run => {
                let reason = "it has joined another run, which has ended";
                Some(Down::Stop(reason.to_owned()))
            }
            Up::Ready(_) => {
                host.stage = host.stage.max(Stage::Ready);
                None
            }
            Up::Answer(answer) => {
                host.check(&answer)?;
                host.answer = Some(answer);
                None
            }
            Up::Report(report) => {
                if host.stage < Stage::Reported {
                    (host.stage, host.asked) = (Stage::Reported, None);
                    host.report = Some(report);
                }
                Some(Down::Received)
            }
            Up::Failed(reason) => return Err(host.failed(&reason)),
            Up::Bye => {
                host.stage = Stage::Left;
                None
            }
            Up::Beat => None,
        };
        reply.map_or(Ok(()), |reply| send(self.carrier, host, &reply))
    }

    /// Sends frames again that have had no answer for a while.
    fn ask_again(&mut self) -> Result<(), BusError> {
        for host in &mut self.hosts {
            if host.answer.is_some() {
                continue;
            }
            if let Some((bytes, since)) = &mut host.asked
                && since.elapsed() > RESEND
            {
                self.carrier.send(&host.remote.name, bytes)?;
                *since = Instant::now();
                host.contact.sent();
            }
        }
        self.beat()
    }

    /// Shows the hosts that this one lives.
    fn beat(&mut self) -> Result<(), BusError> {
        for host in &mut self.hosts {
            if host.stage > Stage::Absent && host.contact.beat_is_due() {
                send(self.carrier, host, &Down::Beat)?;
            }
        }
        Ok(())
    }

    /// Checks that the run goes on and that no host is silent for too long.
    fn check(&self) -> Result<(), BusError> {
        self.presence.check()?;
        for host in self
            .hosts
            .iter()
            .filter(|host| host.stage < Stage::Reported)
        {
            if host.gone.is_some_and(|since| since.elapsed() > GONE_GRACE) {
                return Err(host.failed("its process is gone: killed, or its computer is down"));
            }
            if let Some(problem) = host.contact.too_silent(self.timeout) {
                return Err(host.failed(&problem));
            }
        }
        Ok(())
    }
}

impl Host {
    fn failed(&self, reason: &str) -> BusError {
        BusError::Failed {
            what: format!("host {}", self.remote.name),
            reason: reason.to_owned(),
        }
    }

    /// Checks that an answer is about the robots of the host and no others.
    fn check(&self, answer: &Answer) -> Result<(), BusError> {
        let own = &self.remote.robots;
        let mut answered: Vec<RobotIndex> = answer.commands.iter().map(|own| own.robot).collect();
        answered.sort_unstable();
        let mut expected = own.clone();
        expected.sort_unstable();
        let from_own = answer.positions.iter().all(|sent| own.contains(&sent.from));
        if answered != expected || !from_own {
            return Err(self.failed("it answers for other robots than its own"));
        }
        Ok(())
    }
}

fn find<'h>(hosts: &'h mut [Host], name: &str) -> Option<&'h mut Host> {
    hosts.iter_mut().find(|host| host.remote.name == name)
}

fn send(
    carrier: &mut dyn PlantCarrier,
    host: &mut Host,
    frame: &impl Serialize,
) -> Result<(), BusError> {
    host.contact.sent();
    carrier.send(&host.remote.name, &encode(frame)?)
}
