//! The relay on the wall clock: it passes on encoders, torques and positions, and keeps the clock of its host.

use std::time::{Duration, Instant};

use slipstream_bus::experiment::Topology;
use slipstream_bus::message::RobotIndex;
use slipstream_bus::transport::BusError;
use slipstream_ipc::clock::{Monotonic, RealTime};
use slipstream_ipc::record_pipe::RecordSender;
use slipstream_ipc::services::{AGENT_CHUNK, Services};
use slipstream_ipc::trace;
use slipstream_ipc::wake_page::{Member, Stage};

use super::play::{Play, stopped_by_plant};
use crate::clock::HostClock;
use crate::frame::{AgentState, Batch, Down, End, News, Sent, Up, encode};
use crate::log;
use crate::timing::{NEWS_INTERVAL, PRIORITY, RESEND, TIME_INTERVAL};

/// The relay on the wall clock.
struct WallRelay<'p, 'a> {
    play: &'p mut Play<'a>,
    topology: Topology,
    clock: HostClock,
    /// When the time was asked for last.
    asked: Option<Instant>,
    /// Time 0 of the run on the clock of the plant's host (ns); `None` before it begins.
    start_ns: Option<i64>,
    /// Time of the newest encoders (ns).
    measured_ns: i64,
    /// What the relay itself traces.
    own: RecordSender,
    batch: u64,
    /// The last batch of records, encoded, until it has arrived; and when it was sent.
    pending: Option<(Vec<u8>, Instant)>,
}

/// Passes on what plant and agents send until the run is over. Returns why it ended early, if it did.
pub(super) fn pass_on(
    play: &mut Play<'_>,
    services: &Services,
    recording: bool,
) -> Result<Option<String>, BusError> {
    let _ = RealTime::request(PRIORITY);
    let presence = play.joined.presence.clone();
    let source = play.robots.first().map_or(0, |robot| robot + 1);
    let mut wall = WallRelay {
        topology: Topology::new(&play.joined.experiment),
        clock: HostClock::default(),
        asked: None,
        start_ns: None,
        measured_ns: i64::MIN,
        own: RecordSender::new(services, presence, source, AGENT_CHUNK, recording)?,
        batch: 0,
        pending: None,
        play,
    };
    while !wall.clock.is_known() {
        if let Some(end) = wall.take_frames()? {
            return wall.play.end(end);
        }
        wall.ask_for_time()?;
    }
    let mut said_ready: Option<Instant> = None;
    loop {
        if wall.start_ns.is_none() && said_ready.is_none_or(|since| since.elapsed() > RESEND) {
            wall.play.send(&Up::Ready(wall.play.run))?;
            said_ready = Some(Instant::now());
        }
        if let Some(end) = wall.take_frames()? {
            return wall.end(end);
        }
        wall.set_clock();
        wall.send_new()?;
        wall.send_records()?;
        wall.ask_for_time()?;
        wall.report()?;
    }
}

impl WallRelay<'_, '_> {
    /// Takes the frames that come within a moment. Returns the end of the run, if it has come.
    fn take_frames(&mut self) -> Result<Option<End>, BusError> {
        let mut timeout = NEWS_INTERVAL;
        let before_ns = self.measured_ns;
        while let Some(frame) = self.play.receive_within(timeout)? {
            timeout = Duration::ZERO;
            match frame {
                Down::News(news) => self.take_news(&news)?,
                Down::Time(stamps) => self.clock.take(&stamps, Monotonic::now().to_shared()),
                Down::Kept(number) if number == self.batch => self.pending = None,
                Down::Over(end) => return Ok(Some(end)),
                Down::Stop(reason) => return Err(stopped_by_plant(reason)),
                Down::Kept(_) | Down::Round(_) | Down::Received | Down::Beat => {}
            }
        }
        if self.measured_ns > before_ns {
            self.play
                .plant
                .publish(self.measured_ns, &self.play.encoders)?;
            let wake_page = self.play.joined.wake_page();
            wake_page.publish_progress(self.measured_ns, 0.0, 0.0);
        }
        Ok(None)
    }

    fn take_news(&mut self, news: &News) -> Result<(), BusError> {
        if news.measured.now_ns > self.measured_ns {
            self.play.measure(&news.measured)?;
            self.measured_ns = news.measured.now_ns;
        }
        if self.start_ns.is_none() {
            self.start_ns = Some(news.start_ns);
            self.set_clock();
            self.play
                .plant
                .publish(self.measured_ns, &self.play.encoders)?;
            self.play.joined.wake_page().advance(Stage::Running);
        }
        for position in &news.positions {
            self.play.crossing.deliver(position)?;
            let receivers = self.topology.heard_by(position.from).into_iter();
            for to in receivers.filter(|to| self.play.robots.contains(to)) {
                log::crossed(position, to);
            }
        }
        Ok(())
    }

    /// Sets the time of the run on this host.
    fn set_clock(&mut self) {
        if let Some(start_ns) = self.start_ns {
            let now_ns = Monotonic::now().to_shared();
            let start_ns = start_ns.saturating_add(self.clock.advance(now_ns));
            self.play.joined.wake_page().set_start_ns(start_ns);
            trace::use_clock(self.play.joined.clock());
        }
    }

    /// Sends what the agents have sent since the last call.
    fn send_new(&mut self) -> Result<(), BusError> {
        let mut sent = Sent::default();
        let commands = &mut sent.commands;
        self.play
            .plant
            .drain_commands(|command| commands.push(*command))?;
        let positions = &mut sent.positions;
        self.play
            .crossing
            .poll(|position| positions.push(position))?;
        if !sent.commands.is_empty() || !sent.positions.is_empty() {
            self.offer(&Up::Sent(sent))?;
        }
        Ok(())
    }

    /// Sends records home, one batch after the other, each until it has arrived.
    fn send_records(&mut self) -> Result<(), BusError> {
        self.own.flush_if_due();
        self.play.drain_records()?;
        if self.pending.is_none() && !self.play.chunks.is_empty() {
            self.batch += 1;
            let batch = encode(&Up::Records(Batch {
                number: self.batch,
                records: std::mem::take(&mut self.play.chunks),
            }))?;
            self.play.carrier.offer(&batch)?;
            self.pending = Some((batch, Instant::now()));
        }
        if let Some((batch, since)) = &mut self.pending
            && since.elapsed() > RESEND
        {
            self.play.carrier.offer(batch)?;
            *since = Instant::now();
        }
        Ok(())
    }

    fn ask_for_time(&mut self) -> Result<(), BusError> {
        let interval = if self.clock.is_known() {
            TIME_INTERVAL
        } else {
            TIME_INTERVAL / 4
        };
        if self.asked.is_none_or(|since| since.elapsed() >= interval) {
            self.asked = Some(Instant::now());
            self.offer(&Up::Time(Monotonic::now().to_shared()))?;
        }
        Ok(())
    }

    /// Tells once a second what is known of the clock and of the agents.
    fn report(&mut self) -> Result<(), BusError> {
        if let Some(report) = self.clock.report(Monotonic::now().to_shared()) {
            self.offer(&Up::Clock(report))?;
            self.send_agents()?;
        }
        Ok(())
    }

    fn send_agents(&mut self) -> Result<(), BusError> {
        let wake_page = self.play.joined.wake_page();
        let state = |&robot: &RobotIndex| AgentState {
            robot,
            deaths: wake_page.deaths(Some(robot as usize)),
            deadlines: wake_page.deadlines(Member::Agent(robot as usize)),
        };
        let agents = self.play.robots.iter().map(state).collect();
        self.offer(&Up::Agents(agents))
    }

    /// Sends a frame that is sent again, or replaced by a newer one, if it is lost. A network that is cut holds nothing up.
    fn offer(&mut self, frame: &Up) -> Result<(), BusError> {
        self.play.contact.sent();
        self.play.carrier.offer(&encode(frame)?)
    }

    /// Ends the run on this host. Returns once no batch of records is under way.
    fn end(mut self, end: End) -> Result<Option<String>, BusError> {
        // The error of the last time stamps is known now.
        if let Some(report) = self.clock.report_now(Monotonic::now().to_shared()) {
            self.offer(&Up::Clock(report))?;
        }
        let stopped = self.play.end(end)?;
        self.own.flush();
        while self.pending.is_some() {
            self.take_frames()?;
            self.send_records()?;
        }
        Ok(stopped)
    }
}
