//! Endpoint of an agent: receives encoders, sends torque commands, answers the lockstep.

use std::time::Duration;

use slipstream_bus::message::{DriveCommand, Encoders, RobotIndex};
use slipstream_bus::transport::BusError;

use super::links::LinkEndpoints;
use crate::clock::WallClock;
use crate::presence::{POLL_INTERVAL, Presence};
use crate::services::{CommandPublisher, Services, WorldSubscriber};
use crate::wake_page::Stage;
use crate::wire::WorldHeader;

/// An agent's ports.
#[derive(Debug)]
pub struct AgentEndpoint {
    presence: Presence,
    robot: RobotIndex,
    world: WorldSubscriber,
    commands: CommandPublisher,
    links: LinkEndpoints,
    epoch: u32,
}

/// A round that an agent has to answer.
#[derive(Debug, Clone, Copy)]
pub struct LockstepRound {
    /// The instant of the round (ns).
    pub now_ns: i64,
    /// The robot's encoders at that instant.
    pub encoders: Encoders,
}

/// What came of waiting for a round.
#[derive(Debug, Clone, Copy)]
pub enum Awaited {
    /// A round.
    Round(LockstepRound),
    /// Nothing yet.
    Nothing,
    /// The run is over.
    Over,
}

impl AgentEndpoint {
    /// Opens the ports of `robot`.
    ///
    /// # Errors
    /// A port cannot be created.
    pub fn new(
        services: &Services,
        presence: Presence,
        robot: RobotIndex,
    ) -> Result<Self, BusError> {
        Ok(Self {
            presence,
            robot,
            world: services.world_subscriber()?,
            commands: services.command_publisher()?,
            links: LinkEndpoints::new(services, robot)?,
            epoch: 0,
        })
    }

    /// The robot.
    pub fn robot(&self) -> RobotIndex {
        self.robot
    }

    /// On the wall clock: stamps sent positions with this clock.
    pub fn use_clock(&mut self, clock: WallClock) {
        self.links.use_clock(clock);
    }

    /// In lockstep: waits for the next round. Returns `None` when the run is over.
    ///
    /// # Errors
    /// [`BusError::Stopped`] if the launcher is gone; another error if the transport failed.
    pub fn next_round(&mut self) -> Result<Option<LockstepRound>, BusError> {
        loop {
            match self.await_round(POLL_INTERVAL)? {
                Awaited::Round(round) => return Ok(Some(round)),
                Awaited::Over => return Ok(None),
                Awaited::Nothing => {}
            }
        }
    }

    /// In lockstep: waits for the next round, at most for `timeout`.
    ///
    /// # Errors
    /// As [`Self::next_round`].
    pub fn await_round(&mut self, timeout: Duration) -> Result<Awaited, BusError> {
        let round = self.presence.wake_page().wait_round(self.epoch, timeout);
        self.presence.show();
        let Some(epoch) = round else {
            if self.presence.wake_page().stage() >= Stage::Over {
                return Ok(Awaited::Over);
            }
            self.presence.check_launcher()?;
            return Ok(Awaited::Nothing);
        };
        self.epoch = epoch;
        let Some((header, encoders)) = self.poll_encoders()? else {
            return Err(BusError::failed("world", "a round without encoders"));
        };
        if header.epoch != self.epoch {
            return Err(BusError::failed("world", "encoders of another round"));
        }
        self.links.set_virtual_time(header.now_ns);
        Ok(Awaited::Round(LockstepRound {
            now_ns: header.now_ns,
            encoders,
        }))
    }

    /// In lockstep: answers the current round.
    ///
    /// # Errors
    /// The transport failed.
    pub fn answer(&self, command: DriveCommand) -> Result<(), BusError> {
        let received = self.send_command(DriveCommand {
            epoch: self.epoch,
            ..command
        })?;
        if received == 0 {
            return Err(BusError::QueueFull {
                what: "command".to_owned(),
            });
        }
        self.presence
            .wake_page()
            .answer(self.robot as usize, self.epoch);
        Ok(())
    }

    /// Sends a command to the plant. Returns the number of processes that received it.
    ///
    /// # Errors
    /// The transport failed.
    pub fn send_command(&self, command: DriveCommand) -> Result<usize, BusError> {
        self.commands
            .send_copy(command.into())
            .map_err(|e| BusError::failed("command", e))
    }

    /// The next waiting encoders of this robot, if any.
    fn poll_encoders(&self) -> Result<Option<(WorldHeader, Encoders)>, BusError> {
        let sample = self
            .world
            .receive()
            .map_err(|e| BusError::failed("world", e))?;
        Ok(sample.and_then(|sample| {
            let encoders = sample.payload().get(self.robot as usize);
            encoders.map(|&encoders| (*sample.user_header(), encoders.into()))
        }))
    }

    /// Receives all waiting encoders and returns the newest ones of this robot, if any. Never
    /// blocks.
    ///
    /// # Errors
    /// The transport failed.
    pub fn newest_encoders(&self) -> Result<Option<Encoders>, BusError> {
        let mut newest = None;
        while let Some((_, encoders)) = self.poll_encoders()? {
            newest = Some(encoders);
        }
        Ok(newest)
    }

    /// The ports for positions.
    pub fn links(&mut self) -> &mut LinkEndpoints {
        &mut self.links
    }
}
