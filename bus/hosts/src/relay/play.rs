//! What the relay does on both clocks: it keeps contact with the plant's host, and sends home what its agents record and
//! leave.

use std::time::{Duration, Instant};

use slipstream_bus::message::{DriveCommand, Encoders, RobotIndex};
use slipstream_bus::transport::{BusError, LockstepLink};
use slipstream_ipc::endpoints::{CrossingLinks, PlantEndpoint};
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::record_pipe::RecordReceiver;
use slipstream_ipc::services::Services;
use slipstream_ipc::wake_page::Stage;

use crate::carrier::HostCarrier;
use crate::frame::{Down, End, LeftFile, Measured, Report, Up, decode, encode};
use crate::timing::{Contact, POLL_INTERVAL, RESEND};

/// What the relay needs while the run goes on.
pub(super) struct Play<'a> {
    pub(super) joined: &'a JoinedRun,
    pub(super) carrier: &'a mut dyn HostCarrier,
    pub(super) run: u64,
    pub(super) robots: Vec<RobotIndex>,
    pub(super) plant: PlantEndpoint,
    pub(super) crossing: CrossingLinks,
    pub(super) records: RecordReceiver,
    /// Chunks of records that have not been sent yet.
    pub(super) chunks: Vec<Vec<u8>>,
    pub(super) contact: Contact,
    pub(super) timeout: Duration,
    pub(super) encoders: Vec<Encoders>,
    pub(super) commands: Vec<DriveCommand>,
}

impl<'a> Play<'a> {
    pub(super) fn new(
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
            records: RecordReceiver::new(services, joined.presence.clone())?,
            chunks: Vec::new(),
            contact: Contact::now(),
            timeout: Duration::from_secs_f64(experiment.settings.host_timeout_s),
            encoders: vec![Encoders::default(); all],
            commands: vec![DriveCommand::default(); all],
        })
    }

    /// Waits until the agents of this host are connected.
    pub(super) fn await_agents(&mut self) -> Result<(), BusError> {
        let agents = u32::try_from(self.robots.len()).unwrap_or(u32::MAX);
        while !self.joined.wake_page().wait_ready(agents, POLL_INTERVAL) {
            self.look()?;
        }
        Ok(())
    }

    /// Takes the end of the run: the last encoders. Returns why it ended early, if it did.
    pub(super) fn end(&mut self, end: End) -> Result<Option<String>, BusError> {
        self.measure(&end.measured)?;
        let now_ns = end.measured.now_ns;
        self.plant.publish_final(now_ns, &self.encoders)?;
        self.joined.wake_page().advance(Stage::Over);
        Ok(end.stopped)
    }

    /// Takes the encoders of the robots of this host.
    pub(super) fn measure(&mut self, measured: &Measured) -> Result<(), BusError> {
        for &(robot, encoders) in &measured.encoders {
            let slot = self.encoders.get_mut(robot as usize);
            *slot.ok_or_else(|| BusError::failed("network", "encoders of no robot"))? = encoders;
        }
        Ok(())
    }

    /// Waits until all agents have ended, and sends home what they left until it has arrived.
    pub(super) fn send_report(
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
    pub(super) fn look(&mut self) -> Result<(), BusError> {
        self.drain_records()?;
        match self.receive_within(Duration::ZERO)? {
            Some(Down::Stop(reason)) => Err(stopped_by_plant(reason)),
            _ => Ok(()),
        }
    }

    /// The next frame, if there is one within a moment.
    pub(super) fn receive(&mut self) -> Result<Option<Down>, BusError> {
        self.receive_within(POLL_INTERVAL)
    }

    pub(super) fn receive_within(&mut self, timeout: Duration) -> Result<Option<Down>, BusError> {
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
    pub(super) fn beat(&mut self) -> Result<(), BusError> {
        if self.contact.beat_is_due() {
            self.send(&Up::Beat)?;
        }
        Ok(())
    }

    pub(super) fn send(&mut self, frame: &Up) -> Result<(), BusError> {
        self.contact.sent();
        self.carrier.send(&encode(frame)?)
    }

    /// Takes the chunks of records that wait, so that no agent waits for room.
    pub(super) fn drain_records(&mut self) -> Result<(), BusError> {
        while let Some(chunk) = self.records.poll_chunk(<[u8]>::to_vec)? {
            self.chunks.push(chunk);
        }
        Ok(())
    }

    /// Tells the plant's host why this one cannot go on, unless it knows.
    pub(super) fn fail(&mut self, error: &BusError, failure: &dyn Fn() -> Option<String>) {
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

pub(super) fn stopped_by_plant(reason: String) -> BusError {
    BusError::Failed {
        what: STOPPED_BY_PLANT.to_owned(),
        reason,
    }
}
