//! Relay: the process on another host that takes the part of the plant and of the recorder.
//!
//! To the agents of its host it is what the plant is: it brings them encoders and collects their torques. It sends home
//! what they record, and in the end what they leave.

mod lockstep;
mod wall;

use std::path::Path;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use slipstream_bus::message::{Encoders, RobotIndex, TorqueCommand};
use slipstream_bus::transport::{BusError, LockstepLink};
use slipstream_ipc::endpoints::{CrossingLinks, PlantEndpoint};
use slipstream_ipc::join::{JoinedRun, ProcessStatus};
use slipstream_ipc::presence::Parent;
use slipstream_ipc::record_pipe::RecordReceiver;
use slipstream_ipc::services::Services;
use slipstream_ipc::wake_page::{Member, Stage};

use crate::carrier::HostCarrier;
use crate::frame::{Down, End, LeftFile, Measured, Report, Up, decode, encode};
use crate::timing::{Contact, POLL_INTERVAL, RESEND};

/// What the relay is started with.
pub struct Relay<'a> {
    /// The run directory of this host.
    pub folder: &'a Path,
    /// The launcher of this host.
    pub launcher: Parent,
    /// Number of the run that this host has joined.
    pub run: u64,
    /// The run is recorded.
    pub recording: bool,
    /// The files that the agents of these robots left, in the run directory.
    pub left: &'a dyn Fn(&[RobotIndex]) -> Vec<LeftFile>,
    /// Why the launcher stopped the agents of this host, if it did.
    pub failure: &'a dyn Fn() -> Option<String>,
}

/// How the relay ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RelayOutcome {
    /// How it ended.
    pub ended: ProcessStatus,
}

/// What the relay needs while the run goes on.
struct Play<'a> {
    joined: &'a JoinedRun,
    carrier: &'a mut dyn HostCarrier,
    run: u64,
    robots: Vec<RobotIndex>,
    plant: PlantEndpoint,
    crossing: CrossingLinks,
    records: RecordReceiver,
    /// Chunks of records that have not been sent yet.
    chunks: Vec<Vec<u8>>,
    contact: Contact,
    timeout: Duration,
    encoders: Vec<Encoders>,
    commands: Vec<TorqueCommand>,
}

impl Relay<'_> {
    /// Takes the part of the plant until the run is over and all has been sent home.
    ///
    /// # Errors
    /// It cannot join the run of this host. Errors after that are in [`RelayOutcome::ended`].
    pub fn run(self, carrier: &mut dyn HostCarrier) -> Result<RelayOutcome, BusError> {
        let joined = JoinedRun::new(self.folder, Member::Plant, self.launcher)?;
        let services = Services::join(&joined.directory, &joined.experiment, "relay")?;
        let services = services.with_local(|robot| joined.wake_page().is_local(robot));
        let kept = services.create_all()?;
        joined.wake_page().advance(Stage::Services);
        let mut play = Play::new(&joined, &services, carrier, self.run)?;
        let ended = play
            .await_agents()
            .and_then(|()| {
                drop(kept);
                if services.lockstep() {
                    lockstep::rounds(&mut play)
                } else {
                    wall::pass_on(&mut play, &services, self.recording)
                }
            })
            .and_then(|stopped| {
                play.send_report(self.left, self.failure)?;
                stopped.map_or(Ok(()), |reason| Err(stopped_by_plant(reason)))
            });
        joined.wake_page().advance(Stage::Over);
        if let Err(error) = &ended {
            play.fail(error, self.failure);
        }
        Ok(RelayOutcome {
            ended: ended.into(),
        })
    }
}

impl<'a> Play<'a> {
    fn new(
        joined: &'a JoinedRun,
        services: &Services,
        carrier: &'a mut dyn HostCarrier,
        run: u64,
    ) -> Result<Self, BusError> {
        let experiment = &joined.experiment;
        let all = experiment.robots.len();
        let is_local = |&robot: &RobotIndex| joined.wake_page().is_local(robot);
        Ok(Self {
            joined,
            carrier,
            run,
            robots: (0..experiment.settings.robots.count)
                .filter(is_local)
                .collect(),
            plant: PlantEndpoint::new(services, joined.presence.clone())?,
            crossing: CrossingLinks::new(services)?,
            records: RecordReceiver::new(services)?,
            chunks: Vec::new(),
            contact: Contact::now(),
            timeout: Duration::from_secs_f64(experiment.settings.host_timeout_s),
            encoders: vec![Encoders::default(); all],
            commands: vec![TorqueCommand::default(); all],
        })
    }

    /// Waits until the agents of this host are connected.
    fn await_agents(&mut self) -> Result<(), BusError> {
        let agents = u32::try_from(self.robots.len()).unwrap_or(u32::MAX);
        while !self.joined.wake_page().wait_ready(agents, POLL_INTERVAL) {
            self.look()?;
        }
        Ok(())
    }

    /// Takes the end of the run: the last encoders. Returns why it ended early, if it did.
    fn end(&mut self, end: End) -> Result<Option<String>, BusError> {
        self.measure(&end.measured)?;
        let now_ns = end.measured.now_ns;
        self.plant.publish_final(now_ns, &self.encoders)?;
        self.joined.wake_page().advance(Stage::Over);
        Ok(end.stopped)
    }

    /// Takes the encoders of the robots of this host.
    fn measure(&mut self, measured: &Measured) -> Result<(), BusError> {
        for &(robot, encoders) in &measured.encoders {
            let slot = self.encoders.get_mut(robot as usize);
            *slot.ok_or_else(|| BusError::failed("network", "encoders of no robot"))? = encoders;
        }
        Ok(())
    }

    /// Waits until all agents have ended, and sends home what they left until it has arrived.
    fn send_report(
        &mut self,
        left: &dyn Fn(&[RobotIndex]) -> Vec<LeftFile>,
        failure: &dyn Fn() -> Option<String>,
    ) -> Result<(), BusError> {
        let wake_page = self.joined.wake_page();
        while !wake_page.wait_stage(Stage::Drained, POLL_INTERVAL) {
            self.look()?;
        }
        self.drain_records()?;
        let report = encode(&Up::Report(Report {
            files: left(&self.robots),
            records: std::mem::take(&mut self.chunks),
            failure: failure(),
        }))?;
        let mut sent: Option<Instant> = None;
        loop {
            if sent.is_none_or(|since| since.elapsed() > RESEND) {
                self.carrier.send(&report)?;
                self.contact.sent();
                sent = Some(Instant::now());
            }
            match self.receive()? {
                Some(Down::Received) => return self.send(&Up::Bye),
                Some(Down::Stop(reason)) => return Err(stopped_by_plant(reason)),
                _ => {}
            }
        }
    }

    /// Looks whether the plant's host has ended the run, and shows it that this one lives.
    fn look(&mut self) -> Result<(), BusError> {
        self.drain_records()?;
        match self.receive_within(Duration::ZERO)? {
            Some(Down::Stop(reason)) => Err(stopped_by_plant(reason)),
            _ => Ok(()),
        }
    }

    /// The next frame, if there is one within a moment.
    fn receive(&mut self) -> Result<Option<Down>, BusError> {
        self.receive_within(POLL_INTERVAL)
    }

    fn receive_within(&mut self, timeout: Duration) -> Result<Option<Down>, BusError> {
        let frame = self.carrier.receive(timeout)?;
        self.joined.presence.check()?;
        if let Some(frame) = frame {
            self.contact.heard();
            return decode(&frame).map(Some);
        }
        if let Some(reason) = self.contact.too_silent(self.timeout) {
            return Err(BusError::Failed {
                what: "the plant's host".to_owned(),
                reason,
            });
        }
        self.drain_records()?;
        self.beat()?;
        Ok(None)
    }

    /// Shows the plant's host that this one lives.
    fn beat(&mut self) -> Result<(), BusError> {
        if self.contact.beat_is_due() {
            self.send(&Up::Beat)?;
        }
        Ok(())
    }

    fn send(&mut self, frame: &Up) -> Result<(), BusError> {
        self.contact.sent();
        self.carrier.send(&encode(frame)?)
    }

    /// Takes the chunks of records that wait, so that no agent waits for room.
    fn drain_records(&mut self) -> Result<(), BusError> {
        while let Some(chunk) = self.records.poll_chunk(<[u8]>::to_vec)? {
            self.chunks.push(chunk);
        }
        Ok(())
    }

    /// Tells the plant's host why this one cannot go on, unless it knows.
    fn fail(&mut self, error: &BusError, failure: &dyn Fn() -> Option<String>) {
        let reason = match error {
            BusError::Stopped => failure().unwrap_or_else(|| "it was stopped".to_owned()),
            BusError::Failed { what, .. } if what == STOPPED_BY_PLANT => return,
            other => other.to_string(),
        };
        // If the network is gone, the plant's host notices that.
        let _ = self.send(&Up::Failed(reason));
    }
}

/// The place of a failure that the plant's host has told.
const STOPPED_BY_PLANT: &str = "the plant's host has ended the run";

fn stopped_by_plant(reason: String) -> BusError {
    BusError::Failed {
        what: STOPPED_BY_PLANT.to_owned(),
        reason,
    }
}
