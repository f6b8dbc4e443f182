//! The other hosts, as the stand-in hears them: who has joined, who has answered, who is silent.

use std::time::{Duration, Instant};

use serde::Serialize;
use slipstream_bus::message::RobotIndex;
use slipstream_bus::transport::BusError;
use slipstream_ipc::clock::Monotonic;
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::presence::Presence;

use super::host::{Arrived, Host, Stage};
use crate::carrier::{Event, PlantCarrier};
use crate::clock::Stamps;
use crate::frame::{Answer, Down, Report, Up, decode, encode};
use crate::hello::{Hello, RemoteHost, Welcome};
use crate::timing::{Contact, NEWS_INTERVAL, POLL_INTERVAL, RESEND};

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
    /// The run goes on without a host that is lost.
    goes_on: bool,
    /// What has come on the wall clock: the index of the host, and what.
    arrived: Vec<(usize, Arrived)>,
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
        Self {
            carrier,
            presence: joined.presence.clone(),
            version,
            notice,
            welcome,
            timeout: Duration::from_secs_f64(joined.experiment.settings.host_timeout_s),
            hosts: remote.iter().map(Host::new).collect(),
            goes_on: false,
            arrived: Vec::new(),
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
        for host in not_lost(&mut self.hosts) {
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
            stage => stage >= Stage::Left,
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

    /// From now on a host that is lost does not end the run.
    pub(super) fn go_on_without_the_lost(&mut self) {
        self.goes_on = true;
    }

    /// On the wall clock: sends every host a frame for its robots, which may be lost.
    pub(super) fn offer(&mut self, frame: impl Fn(&[RobotIndex]) -> Down) -> Result<(), BusError> {
        for host in not_lost(&mut self.hosts) {
            let bytes = encode(&frame(&host.remote.robots))?;
            self.carrier.offer(&host.remote.name, &bytes)?;
            host.contact.sent();
        }
        Ok(())
    }

    /// On the wall clock: waits for frames for a moment. Returns what has come, and from which host.
    pub(super) fn listen(&mut self) -> Result<Vec<(RemoteHost, Arrived)>, BusError> {
        self.receive(NEWS_INTERVAL)?;
        self.beat()?;
        self.check()?;
        Ok(self.take_arrived())
    }

    /// What has come on the wall clock, and from which host.
    pub(super) fn take_arrived(&mut self) -> Vec<(RemoteHost, Arrived)> {
        let hosts = &self.hosts;
        let arrived = self.arrived.drain(..);
        let named = arrived.filter_map(|(index, arrived)| {
            let host = hosts.get(index)?;
            Some((host.remote.clone(), arrived))
        });
        named.collect()
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
                Event::Refused { reason } => {
                    (self.notice)(&format!(
                        "refused a connection: {reason}; give all hosts the same folder of slipstream keys"
                    ));
                }
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
        let received_ns = Monotonic::now().to_shared();
        let mut hosts = self.hosts.iter_mut().enumerate();
        let Some((index, host)) = hosts.find(|(_, host)| host.remote.name == name) else {
            return Ok(());
        };
        if host.stage == Stage::Lost {
            let reason = "the run went on without it".to_owned();
            return send(self.carrier, host, &Down::Stop(reason));
        }
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
            Up::Time(asked_ns) => Some(Down::Time(Stamps {
                asked_ns,
                received_ns,
                sent_ns: Monotonic::now().to_shared(),
            })),
            Up::Sent(sent) => {
                host.check_sent(&sent)?;
                self.arrived.push((index, Arrived::Sent(sent)));
                None
            }
            Up::Records(batch) => {
                if batch.number > host.kept {
                    host.kept = batch.number;
                    self.arrived.push((index, Arrived::Records(batch.records)));
                }
                Some(Down::Kept(batch.number))
            }
            Up::Clock(report) => {
                self.arrived.push((index, Arrived::Clock(report)));
                None
            }
            Up::Agents(agents) => {
                self.arrived.push((index, Arrived::Agents(agents)));
                None
            }
            Up::Report(report) => {
                if host.stage < Stage::Reported {
                    (host.stage, host.asked) = (Stage::Reported, None);
                    host.report = Some(report);
                }
                Some(Down::Received)
            }
            Up::Failed(reason) => return self.lose(index, reason),
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
    fn check(&mut self) -> Result<(), BusError> {
        self.presence.check()?;
        for index in 0..self.hosts.len() {
            let host = self.hosts.get(index);
            if let Some(problem) = host.and_then(|host| host.problem(self.timeout)) {
                self.lose(index, problem)?;
            }
        }
        Ok(())
    }

    /// Gives a host up.
    ///
    /// # Errors
    /// The run does not go on without it.
    fn lose(&mut self, index: usize, reason: String) -> Result<(), BusError> {
        let Some(host) = self.hosts.get_mut(index) else {
            return Ok(());
        };
        if !self.goes_on {
            return Err(host.failed(&reason));
        }
        (host.stage, host.asked) = (Stage::Lost, None);
        self.arrived.push((index, Arrived::Lost(reason)));
        Ok(())
    }
}

fn not_lost(hosts: &mut [Host]) -> impl Iterator<Item = &mut Host> {
    hosts.iter_mut().filter(|host| host.stage < Stage::Lost)
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
