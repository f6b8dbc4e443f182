//! The ends of a run over shared memory: data by pub-sub, waking by the wake_page page.

use std::rc::Rc;
use std::time::{Duration, Instant};

use rustix::process::{Pid, getppid};

use crate::clock::WallClock;
use crate::services::{
    CommandPublisher, CommandSubscriber, PositionPublisher, PositionSubscriber, Services,
    WorldPublisher, WorldSubscriber,
};
use crate::wake_page::{Stage, WakePage};
use crate::wire::{WireEncoders, WorldHeader};
use slipstream_bus::message::{Encoders, Position, RobotIndex, TorqueCommand, robot_name};
use slipstream_bus::transport::{BusError, LockstepLink, PositionLink};

/// After this long whoever waits looks whether the others live.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// After this long a process that neither answers nor ends counts as dead.
const TIMEOUT: Duration = Duration::from_secs(10);
/// LockstepLink between two looks at the launcher.
const ROUNDS_PER_PARENT_CHECK: u32 = 64;

/// Knows whether the launcher still lives.
#[derive(Debug, Clone, Copy)]
pub struct Parent(Option<Pid>);

impl Parent {
    /// To be asked for at the start, while it certainly lives or has just died.
    pub fn now() -> Self {
        Self(getppid())
    }

    /// The launcher is gone.
    pub fn is_gone(self) -> bool {
        getppid() != self.0
    }
}

/// Waits until the run has reached `stage`.
///
/// # Errors
/// When the run ends instead, or the launcher does.
pub fn await_stage(wake_page: &WakePage, stage: Stage, parent: Parent) -> Result<(), BusError> {
    while !wake_page.wait_stage(stage, POLL_INTERVAL) {
        if wake_page.stopping() || parent.is_gone() {
            return Err(BusError::Stopped);
        }
    }
    Ok(())
}

/// The plant's end.
#[derive(Debug)]
pub struct PlantEnd {
    wake_page: Rc<WakePage>,
    parent: Parent,
    world: WorldPublisher,
    commands: CommandSubscriber,
    robots: usize,
    epoch: u32,
}

impl PlantEnd {
    /// Opens the plant's ports.
    ///
    /// # Errors
    /// When a port cannot be made.
    pub fn new(
        services: &Services,
        wake_page: Rc<WakePage>,
        parent: Parent,
    ) -> Result<Self, BusError> {
        Ok(Self {
            wake_page,
            parent,
            world: services.world_publisher()?,
            commands: services.command_subscriber()?,
            robots: services.robots(),
            epoch: 0,
        })
    }

    /// Waits until `processes` others are connected.
    ///
    /// # Errors
    /// When the run ends before.
    pub fn await_ready(&self, processes: u32) -> Result<(), BusError> {
        while !self.wake_page.wait_ready(processes, POLL_INTERVAL) {
            self.check()?;
        }
        Ok(())
    }

    /// Publishes the encoders of all robots; says how many received them.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn publish(&self, now_ns: i64, encoders: &[Encoders]) -> Result<usize, BusError> {
        let failed = |e| BusError::failed("world", e);
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
            .write_from_fn(|i| WireEncoders::from(encoders[i]))
            .send()
            .map_err(failed)
    }

    /// Takes all commands that have come; `each` hears them.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn take_commands(&self, mut each: impl FnMut(&TorqueCommand)) -> Result<(), BusError> {
        while let Some(sample) = self
            .commands
            .receive()
            .map_err(|e| BusError::failed("command", e))?
        {
            each(&TorqueCommand::from(*sample.payload()));
        }
        Ok(())
    }

    /// Whether the run is to go on.
    ///
    /// # Errors
    /// [`BusError::Stopped`] when it is not.
    pub fn check(&self) -> Result<(), BusError> {
        if self.wake_page.stopping() || self.parent.is_gone() {
            return Err(BusError::Stopped);
        }
        Ok(())
    }

    fn await_answers(&self) -> Result<(), BusError> {
        let begin = Instant::now();
        while !self.wake_page.wait_answers(POLL_INTERVAL) {
            self.check()?;
            if begin.elapsed() > TIMEOUT {
                return Err(self.unanswered());
            }
        }
        Ok(())
    }

    fn unanswered(&self) -> BusError {
        let robot = self.wake_page.first_unanswered(self.epoch).unwrap_or(0);
        BusError::NoAnswer {
            robot: robot_name(u32::try_from(robot).unwrap_or(0)),
        }
    }
}

impl LockstepLink for PlantEnd {
    fn round(
        &mut self,
        now_ns: i64,
        encoders: &[Encoders],
        commands: &mut [TorqueCommand],
    ) -> Result<(), BusError> {
        if self.wake_page.stopping()
            || (self.epoch.is_multiple_of(ROUNDS_PER_PARENT_CHECK) && self.parent.is_gone())
        {
            return Err(BusError::Stopped);
        }
        self.epoch = self.epoch.wrapping_add(1).max(1);
        if self.publish(now_ns, encoders)? < self.robots {
            return Err(BusError::QueueFull {
                what: "world".to_owned(),
            });
        }
        self.wake_page.begin_round(self.epoch);
        self.await_answers()?;
        let mut answers = 0;
        self.take_commands(|command| {
            if command.epoch == self.epoch {
                commands[command.robot as usize] = *command;
                answers += 1;
            }
        })?;
        if answers < self.robots {
            return Err(self.unanswered());
        }
        Ok(())
    }

    fn publish_final(&mut self, now_ns: i64, encoders: &[Encoders]) -> Result<(), BusError> {
        self.publish(now_ns, encoders).map(|_| ())
    }
}

/// An agent's end.
#[derive(Debug)]
pub struct AgentEnd {
    wake_page: Rc<WakePage>,
    parent: Parent,
    robot: RobotIndex,
    world: WorldSubscriber,
    commands: CommandPublisher,
    links: LinkEndpoints,
    epoch: u32,
}

/// An agent's end of the links to its neighbours.
#[derive(Debug)]
pub struct LinkEndpoints {
    ahead: Option<(RobotIndex, PositionSubscriber)>,
    behind: Option<PositionPublisher>,
    /// How many must receive what is sent; nobody must on the wall clock.
    listeners: usize,
    time: SendTime,
}

/// What stamps positions.
#[derive(Debug, Clone, Copy)]
enum SendTime {
    /// The instant of the round.
    Virtual(i64),
    /// The clock.
    Wall(WallClock),
}

/// A round that an agent is to answer.
#[derive(Debug, Clone, Copy)]
pub struct Round {
    /// The instant (ns).
    pub now_ns: i64,
    /// The robot's encoders.
    pub encoders: Encoders,
}

impl AgentEnd {
    /// Opens the ports of robot `robot`.
    ///
    /// # Errors
    /// When a port cannot be made.
    pub fn new(
        services: &Services,
        wake_page: Rc<WakePage>,
        parent: Parent,
        robot: RobotIndex,
    ) -> Result<Self, BusError> {
        let topology = services.topology();
        let ahead = topology.predecessor(robot);
        let behind = topology.successor(robot);
        Ok(Self {
            wake_page,
            parent,
            robot,
            world: services.world_subscriber()?,
            commands: services.command_publisher()?,
            links: LinkEndpoints {
                ahead: ahead
                    .map(|ahead| Ok((ahead, services.position_subscriber(ahead)?)))
                    .transpose()?,
                behind: behind
                    .map(|_| services.position_publisher(robot))
                    .transpose()?,
                listeners: if services.lockstep() {
                    services.listeners(robot)
                } else {
                    0
                },
                time: SendTime::Virtual(0),
            },
            epoch: 0,
        })
    }

    /// The robot.
    pub fn robot(&self) -> RobotIndex {
        self.robot
    }

    /// On the wall clock positions carry its time.
    pub fn use_clock(&mut self, clock: WallClock) {
        self.links.time = SendTime::Wall(clock);
    }

    /// Lockstep: waits for the next round; `None` when the run is over.
    ///
    /// # Errors
    /// When the launcher is gone or the transport fails.
    pub fn next_round(&mut self) -> Result<Option<Round>, BusError> {
        loop {
            if let Some(epoch) = self.wake_page.wait_round(self.epoch, POLL_INTERVAL) {
                self.epoch = epoch;
                break;
            }
            if self.wake_page.stage() >= Stage::Over {
                return Ok(None);
            }
            if self.parent.is_gone() {
                return Err(BusError::Stopped);
            }
        }
        let Some((header, encoders)) = self.next_world()? else {
            return Err(BusError::failed("world", "a round without encoders"));
        };
        if header.epoch != self.epoch {
            return Err(BusError::failed("world", "encoders of another round"));
        }
        self.links.time = SendTime::Virtual(header.now_ns);
        Ok(Some(Round {
            now_ns: header.now_ns,
            encoders,
        }))
    }

    /// Lockstep: answers the round.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn answer(&self, command: TorqueCommand) -> Result<(), BusError> {
        let received = self.command(TorqueCommand {
            epoch: self.epoch,
            ..command
        })?;
        if received == 0 {
            return Err(BusError::QueueFull {
                what: "command".to_owned(),
            });
        }
        self.wake_page.answer(self.robot as usize, self.epoch);
        Ok(())
    }

    /// Sends a command to the plant; says how many received it.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn command(&self, command: TorqueCommand) -> Result<usize, BusError> {
        self.commands
            .send_copy(command.into())
            .map_err(|e| BusError::failed("command", e))
    }

    /// The next encoders of this robot, if any came.
    fn next_world(&self) -> Result<Option<(WorldHeader, Encoders)>, BusError> {
        let sample = self
            .world
            .receive()
            .map_err(|e| BusError::failed("world", e))?;
        Ok(sample.and_then(|sample| {
            let encoders = sample.payload().get(self.robot as usize);
            encoders.map(|&encoders| (*sample.user_header(), encoders.into()))
        }))
    }

    /// The newest encoders of this robot, if any came since the last call.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn newest_world(&self) -> Result<Option<(WorldHeader, Encoders)>, BusError> {
        let mut newest = None;
        while let Some(next) = self.next_world()? {
            newest = Some(next);
        }
        Ok(newest)
    }

    /// The links to the neighbours.
    pub fn links(&mut self) -> &mut LinkEndpoints {
        &mut self.links
    }
}

impl PositionLink for LinkEndpoints {
    fn poll(&mut self) -> Result<Option<Position>, BusError> {
        let Some((ahead, subscriber)) = &self.ahead else {
            return Ok(None);
        };
        loop {
            match subscriber
                .receive()
                .map_err(|e| BusError::failed("position", e))?
            {
                Some(sample) if sample.from == *ahead => {
                    return Ok(Some((*sample.payload()).into()));
                }
                Some(_) => {}
                None => return Ok(None),
            }
        }
    }

    fn send(&mut self, position: &mut Position) -> Result<i64, BusError> {
        let Some(publisher) = &self.behind else {
            return Ok(position.tick_ns);
        };
        position.sent_ns = self.time.now_ns();
        let received = publisher
            .send_copy((*position).into())
            .map_err(|e| BusError::failed("position", e))?;
        if received < self.listeners {
            return Err(BusError::QueueFull {
                what: "position".to_owned(),
            });
        }
        Ok(self.time.now_ns())
    }

    fn now_ns(&self) -> i64 {
        self.time.now_ns()
    }
}

impl SendTime {
    fn now_ns(self) -> i64 {
        match self {
            Self::Virtual(now_ns) => now_ns,
            Self::Wall(clock) => clock.now_ns(),
        }
    }
}
