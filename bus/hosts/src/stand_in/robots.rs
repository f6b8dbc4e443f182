//! The agents that the stand-in takes the part of, with their ports on the plant's host.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use slipstream_bus::experiment::Topology;
use slipstream_bus::message::{Encoders, Position, RobotIndex};
use slipstream_bus::transport::{BusError, PositionLink};
use slipstream_ipc::endpoints::{AgentEndpoint, Awaited};
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::record_pipe::{ChunkSender, source_of};
use slipstream_ipc::services::{AGENT_CHUNK, Services};

use crate::frame::{Answer, Measured, News, Round, Sent};
use crate::hello::{RemoteHost, robots_of};
use crate::timing::NEWS_INTERVAL;

/// Time that the recorder has to take what has come in the end.
const RECORDER_GRACE: Duration = Duration::from_secs(1);

/// The agents on other hosts.
pub(super) struct Robots {
    endpoints: Vec<AgentEndpoint>,
    topology: Topology,
    recorder: Option<ChunkSender>,
    /// Chunks of records that the recorder has had no room for yet.
    chunks: VecDeque<Vec<u8>>,
    now_ns: i64,
    /// The newest encoders of each robot.
    encoders: Vec<(RobotIndex, Encoders)>,
    /// Positions for these robots that have not been sent to their hosts yet.
    positions: Vec<(RobotIndex, Position)>,
    lost_chunks: u64,
}

impl Robots {
    /// Opens the ports of all agents on other hosts, as each of them would.
    pub(super) fn join(
        joined: &JoinedRun,
        services: &Services,
        hosts: &[RemoteHost],
        recording: bool,
    ) -> Result<Self, BusError> {
        let presence = || joined.presence.clone();
        let endpoints: Vec<AgentEndpoint> = robots_of(hosts)
            .map(|robot| AgentEndpoint::new(services, presence(), robot))
            .collect::<Result<_, _>>()?;
        let recorder = recording
            .then(|| ChunkSender::new(services, presence(), AGENT_CHUNK))
            .transpose()?;
        for _ in &endpoints {
            joined.wake_page().signal_ready();
        }
        Ok(Self {
            endpoints,
            topology: Topology::new(&joined.experiment),
            recorder,
            chunks: VecDeque::new(),
            now_ns: 0,
            encoders: Vec::new(),
            positions: Vec::new(),
            lost_chunks: 0,
        })
    }

    /// Waits for a round of the plant, at most for `timeout`, and takes its encoders.
    pub(super) fn await_round(&mut self, timeout: Duration) -> Result<Awaited, BusError> {
        let Some((first, others)) = self.endpoints.split_first_mut() else {
            return Ok(Awaited::Over);
        };
        let awaited = first.await_round(timeout)?;
        if let Awaited::Round(round) = awaited {
            self.now_ns = round.now_ns;
            self.encoders.clear();
            self.encoders.push((first.robot(), round.encoders));
            for other in others {
                let Some(round) = other.next_round()? else {
                    return Ok(Awaited::Over);
                };
                self.encoders.push((other.robot(), round.encoders));
            }
        }
        Ok(awaited)
    }

    /// Takes the encoders that the plant publishes at the end of the run.
    pub(super) fn take_last_encoders(&mut self) -> Result<(), BusError> {
        for (endpoint, (_, encoders)) in self.endpoints.iter().zip(&mut self.encoders) {
            if let Some(newest) = endpoint.newest_encoders()? {
                self.now_ns = newest.sampled_ns;
                *encoders = newest;
            }
        }
        Ok(())
    }

    /// On the wall clock: takes the newest encoders and the positions that wait. Returns whether there was anything.
    pub(super) fn look(&mut self) -> Result<bool, BusError> {
        self.take_positions()?;
        let mut is_new = !self.positions.is_empty();
        for endpoint in &self.endpoints {
            if let Some(newest) = endpoint.newest_encoders()? {
                self.now_ns = newest.sampled_ns.max(self.now_ns);
                let robot = endpoint.robot();
                match self.encoders.iter_mut().find(|(known, _)| *known == robot) {
                    Some((_, encoders)) => *encoders = newest,
                    None => self.encoders.push((robot, newest)),
                }
                is_new = true;
            }
        }
        Ok(is_new)
    }

    /// On the wall clock: what is new for the host with these robots.
    pub(super) fn news(&self, start_ns: i64, own: &[RobotIndex]) -> News {
        News {
            start_ns,
            measured: self.measured(own),
            positions: self.positions_for(own),
        }
    }

    /// On the wall clock: passes on what the agents of a host have sent.
    pub(super) fn pass_on(&mut self, sent: &Sent) -> Result<(), BusError> {
        for position in &sent.positions {
            if let Some(sender) = self.endpoint(position.from) {
                sender.links().forward(position)?;
            }
        }
        for command in &sent.commands {
            if let Some(endpoint) = self.endpoint(command.robot) {
                endpoint.send_command(*command)?;
            }
        }
        Ok(())
    }

    /// Takes the positions that wait for these robots.
    pub(super) fn take_positions(&mut self) -> Result<(), BusError> {
        self.positions.clear();
        for endpoint in &mut self.endpoints {
            let to = endpoint.robot();
            while let Some(position) = endpoint.links().poll()? {
                self.positions.push((to, position));
            }
        }
        Ok(())
    }

    /// The round for the host with these robots.
    pub(super) fn round(&self, number: u64, own: &[RobotIndex]) -> Round {
        Round {
            number,
            measured: self.measured(own),
            positions: self.positions_for(own),
        }
    }

    /// The positions that robots of other hosts have sent to these. Their host hands one to all of them, so that it goes there once:
    /// as it came to the first of them that hears the sender.
    fn positions_for(&self, own: &[RobotIndex]) -> Vec<Position> {
        let goes = |&&(to, position): &&(RobotIndex, Position)| {
            let receivers = own
                .iter()
                .filter(|&&own| self.topology.is_link(position.from, own));
            receivers.min() == Some(&to) && !own.contains(&position.from)
        };
        let positions = self.positions.iter().filter(goes);
        positions.map(|&(_, position)| position).collect()
    }

    /// The encoders of these robots.
    pub(super) fn measured(&self, own: &[RobotIndex]) -> Measured {
        let encoders = self.encoders.iter().copied();
        Measured {
            now_ns: self.now_ns,
            encoders: encoders.filter(|(robot, _)| own.contains(robot)).collect(),
        }
    }

    /// Answers the round for the robots of a host: sends their positions and records, then their torques.
    pub(super) fn answer(&mut self, own: &[RobotIndex], answer: Answer) -> Result<(), BusError> {
        self.record(own, answer.records);
        for position in &answer.positions {
            let sender = self
                .endpoint(position.from)
                .filter(|_| own.contains(&position.from));
            if let Some(sender) = sender {
                sender.links().forward(position)?;
            }
        }
        for command in &answer.commands {
            if let Some(endpoint) = self.endpoint(command.robot) {
                endpoint.answer(*command)?;
            }
        }
        Ok(())
    }

    /// Hands chunks of records of these robots to the recorder. On the wall clock some may have to wait.
    pub(super) fn record(&mut self, own: &[RobotIndex], chunks: Vec<Vec<u8>>) {
        for chunk in chunks {
            let is_own = source_of(&chunk).is_some_and(|robot| own.contains(&robot));
            if is_own && chunk.len() <= AGENT_CHUNK {
                self.chunks.push_back(chunk);
            } else {
                self.lost_chunks += 1;
            }
        }
        self.hand_over();
    }

    /// Hands what has waited to the recorder, as far as it has room.
    pub(super) fn hand_over(&mut self) {
        let Some(recorder) = &self.recorder else {
            self.chunks.clear();
            return;
        };
        while let Some(chunk) = self.chunks.front() {
            if !recorder.deliver(chunk) {
                if !recorder.recorder_lives() {
                    self.lost_chunks += self.chunks.len() as u64;
                    self.chunks.clear();
                }
                return;
            }
            self.chunks.pop_front();
        }
    }

    /// Hands all that has waited to the recorder; what it does not take in a second is lost.
    pub(super) fn hand_over_the_rest(&mut self) {
        let begin = Instant::now();
        self.hand_over();
        while !self.chunks.is_empty() && begin.elapsed() < RECORDER_GRACE {
            std::thread::sleep(NEWS_INTERVAL);
            self.hand_over();
        }
        self.lost_chunks += self.chunks.len() as u64;
        self.chunks.clear();
        if let Some(recorder) = &self.recorder {
            recorder.await_taken();
        }
    }

    /// Number of chunks of records that did not reach the recorder.
    pub(super) fn lost_chunks(&self) -> u64 {
        self.lost_chunks
    }

    fn endpoint(&mut self, robot: RobotIndex) -> Option<&mut AgentEndpoint> {
        let mut endpoints = self.endpoints.iter_mut();
        endpoints.find(|endpoint| endpoint.robot() == robot)
    }
}
