//! The agents that the stand-in takes the part of, with their ports on the plant's host.

use std::time::Duration;

use slipstream_bus::message::{Encoders, Position, RobotIndex};
use slipstream_bus::transport::{BusError, PositionLink};
use slipstream_ipc::endpoints::{AgentEndpoint, Awaited};
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::record_pipe::{ChunkSender, source_of};
use slipstream_ipc::services::AGENT_CHUNK;

use crate::frame::{Answer, Measured, Round};
use crate::hello::RemoteHost;

/// The agents on other hosts.
pub(super) struct Robots {
    endpoints: Vec<AgentEndpoint>,
    recorder: Option<ChunkSender>,
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
        hosts: &[RemoteHost],
        recording: bool,
    ) -> Result<Self, BusError> {
        let services = joined.services("hosts")?;
        let presence = || joined.presence.clone();
        let robots = hosts.iter().flat_map(|host| &host.robots);
        let endpoints: Vec<AgentEndpoint> = robots
            .map(|&robot| AgentEndpoint::new(&services, presence(), robot))
            .collect::<Result<_, _>>()?;
        let recorder = recording
            .then(|| ChunkSender::new(&services, presence(), AGENT_CHUNK))
            .transpose()?;
        for _ in &endpoints {
            joined.wake_page().signal_ready();
        }
        Ok(Self {
            endpoints,
            recorder,
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
        let positions = self.positions.iter();
        Round {
            number,
            measured: self.measured(own),
            positions: positions
                .filter(|(to, _)| own.contains(to))
                .map(|&(_, position)| position)
                .collect(),
        }
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
    pub(super) fn answer(&mut self, own: &[RobotIndex], answer: &Answer) -> Result<(), BusError> {
        self.record(own, &answer.records);
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

    /// Hands chunks of records of these robots to the recorder.
    pub(super) fn record(&mut self, own: &[RobotIndex], chunks: &[Vec<u8>]) {
        let Some(recorder) = &self.recorder else {
            return;
        };
        for chunk in chunks {
            let is_own = source_of(chunk).is_some_and(|robot| own.contains(&robot));
            let delivered = is_own && chunk.len() <= AGENT_CHUNK && recorder.deliver(chunk);
            self.lost_chunks += u64::from(!delivered);
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
