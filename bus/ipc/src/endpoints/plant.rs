//! Endpoint of the plant: publishes encoders, receives torque commands, leads the lockstep.

use std::time::{Duration, Instant};

use slipstream_bus::message::{DriveCommand, Encoders, robot_name};
use slipstream_bus::transport::{BusError, LockstepLink};

use crate::presence::{POLL_INTERVAL, Presence};
use crate::services::{CommandSubscriber, Services, WorldPublisher};
use crate::wake_page::WakePage;
use crate::wire::{WireEncoders, WorldHeader};

/// Default timeout for the answers of a round.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(10);
/// Number of rounds between two checks whether the launcher is alive.
const ROUNDS_PER_LAUNCHER_CHECK: u32 = 64;

/// The plant's ports.
#[derive(Debug)]
pub struct PlantEndpoint {
    presence: Presence,
    world: WorldPublisher,
    commands: CommandSubscriber,
    /// Number of agents that take part on this host.
    agents: usize,
    epoch: u32,
    answer_timeout: Duration,
}

impl PlantEndpoint {
    /// Opens the plant's ports.
    ///
    /// # Errors
    /// A port cannot be created.
    pub fn new(services: &Services, presence: Presence) -> Result<Self, BusError> {
        Ok(Self {
            presence,
            world: services.world_publisher()?,
            commands: services.command_subscriber()?,
            agents: services.agents(),
            epoch: 0,
            answer_timeout: ANSWER_TIMEOUT,
        })
    }

    /// Sets how long a round waits for the answers of the agents; 10 s by default.
    pub fn set_answer_timeout(&mut self, timeout: Duration) {
        self.answer_timeout = timeout;
    }

    /// Waits until `processes` others are connected.
    ///
    /// # Errors
    /// [`BusError::Stopped`] if the run is stopped first or the launcher is gone.
    pub fn await_ready(&self, processes: u32) -> Result<(), BusError> {
        while !self.wake_page().wait_ready(processes, POLL_INTERVAL) {
            self.check_running()?;
        }
        Ok(())
    }

    /// Publishes the encoders of all robots. Returns the number of processes that received them.
    ///
    /// # Errors
    /// The transport failed.
    pub fn publish(&self, now_ns: i64, encoders: &[Encoders]) -> Result<usize, BusError> {
        let mut sample = self
            .world
            .loan_slice_uninit(encoders.len())
            .map_err(|e| BusError::failed("world", e))?;
        *sample.user_header_mut() = WorldHeader {
            now_ns,
            epoch: self.epoch,
            reserved: 0,
        };
        sample
            .write_from_fn(|robot| WireEncoders::from(encoders[robot]))
            .send()
            .map_err(|e| BusError::failed("world", e))
    }

    /// Receives all waiting torque commands and calls `each` with every one. Never blocks.
    ///
    /// # Errors
    /// The transport failed.
    pub fn drain_commands(&self, mut each: impl FnMut(&DriveCommand)) -> Result<(), BusError> {
        while let Some(sample) = self
            .commands
            .receive()
            .map_err(|e| BusError::failed("command", e))?
        {
            each(&DriveCommand::from(*sample.payload()));
        }
        Ok(())
    }

    /// Checks that the run goes on, and shows that the plant lives.
    ///
    /// # Errors
    /// [`BusError::Stopped`] if the run was asked to stop or the launcher is gone.
    pub fn check_running(&self) -> Result<(), BusError> {
        self.presence.check()
    }

    fn wake_page(&self) -> &WakePage {
        self.presence.wake_page()
    }

    /// Begins a round: wakes every agent at `now_ns` with its encoders.
    ///
    /// # Errors
    /// [`BusError::Stopped`] if the run was asked to stop or the launcher is gone; another error if the transport
    /// failed.
    pub fn begin_round(&mut self, now_ns: i64, encoders: &[Encoders]) -> Result<(), BusError> {
        if self.epoch.is_multiple_of(ROUNDS_PER_LAUNCHER_CHECK) {
            self.presence.check_launcher()?;
        }
        if self.wake_page().stopping() {
            return Err(BusError::Stopped);
        }
        self.presence.show();
        self.epoch = self.epoch.wrapping_add(1).max(1);
        if self.publish(now_ns, encoders)? < self.agents {
            return Err(BusError::QueueFull {
                what: "world".to_owned(),
            });
        }
        self.wake_page().begin_round(self.epoch);
        Ok(())
    }

    /// Waits until all agents have answered the round, at most for a moment. Returns whether they have.
    ///
    /// # Errors
    /// [`BusError::Stopped`] if the run was asked to stop or the launcher is gone.
    pub fn await_answers(&self) -> Result<bool, BusError> {
        if self.wake_page().wait_answers(POLL_INTERVAL) {
            return Ok(true);
        }
        self.check_running()?;
        Ok(false)
    }

    /// Stores the answers of the round in `commands`, by robot.
    ///
    /// # Errors
    /// An agent has not answered, or the transport failed.
    pub fn take_answers(&self, commands: &mut [DriveCommand]) -> Result<(), BusError> {
        let mut answers = 0;
        self.drain_commands(|command| {
            if command.epoch == self.epoch {
                commands[command.robot as usize] = *command;
                answers += 1;
            }
        })?;
        if answers < self.agents {
            return Err(self.no_answer());
        }
        Ok(())
    }

    /// The error that names the first robot without an answer.
    fn no_answer(&self) -> BusError {
        let robot = self.wake_page().first_unanswered(self.epoch).unwrap_or(0);
        BusError::NoAnswer {
            robot: robot_name(u32::try_from(robot).unwrap_or(0)),
        }
    }
}

impl LockstepLink for PlantEndpoint {
    fn round(
        &mut self,
        now_ns: i64,
        encoders: &[Encoders],
        commands: &mut [DriveCommand],
    ) -> Result<(), BusError> {
        self.begin_round(now_ns, encoders)?;
        let begin = Instant::now();
        while !self.await_answers()? {
            if begin.elapsed() > self.answer_timeout {
                return Err(self.no_answer());
            }
        }
        self.take_answers(commands)
    }

    fn publish_final(&mut self, now_ns: i64, encoders: &[Encoders]) -> Result<(), BusError> {
        self.publish(now_ns, encoders).map(|_| ())
    }
}
