//! Link endpoints of an agent: receives positions from the robots that it hears, sends to those that hear it.

use slipstream_bus::message::{Position, RobotIndex};
use slipstream_bus::transport::{BusError, PositionLink};

use crate::clock::WallClock;
use crate::services::{PositionPublisher, PositionSubscriber, Services};

/// An agent's ports for positions.
#[derive(Debug)]
pub struct LinkEndpoints {
    /// The robots that are heard, in order.
    hears: Vec<RobotIndex>,
    /// A port for each of their groups, and which one is asked next.
    subscribers: Vec<PositionSubscriber>,
    next: usize,
    /// None if nobody hears the robot.
    publisher: Option<PositionPublisher>,
    /// Number of processes that must receive what is sent: in lockstep all, on the wall clock none.
    required_receivers: usize,
    time: SendTime,
}

/// Source of the time stamps of sent positions.
#[derive(Debug, Clone, Copy)]
enum SendTime {
    /// The instant of the current round (ns).
    Virtual(i64),
    /// The wall clock.
    Wall(WallClock),
}

impl LinkEndpoints {
    /// Opens the ports of `robot`.
    pub(super) fn new(services: &Services, robot: RobotIndex) -> Result<Self, BusError> {
        let topology = services.topology();
        let is_heard = !topology.heard_by(robot).is_empty();
        let groups = services.groups_heard(robot).into_iter();
        Ok(Self {
            hears: topology.hears(robot),
            subscribers: groups
                .map(|group| services.position_subscriber(group))
                .collect::<Result<_, _>>()?,
            next: 0,
            publisher: is_heard
                .then(|| services.position_publisher(robot))
                .transpose()?,
            required_receivers: if services.lockstep() {
                services.position_receivers(robot)
            } else {
                0
            },
            time: SendTime::Virtual(0),
        })
    }

    /// Sends a position to those that hear the robot, with the time stamps that it has.
    ///
    /// # Errors
    /// The transport failed, or a receiver's queue is full.
    pub fn forward(&self, position: &Position) -> Result<(), BusError> {
        let Some(publisher) = &self.publisher else {
            return Ok(());
        };
        let received = publisher
            .send_copy((*position).into())
            .map_err(|e| BusError::failed("position", e))?;
        if received < self.required_receivers {
            return Err(BusError::QueueFull {
                what: "position".to_owned(),
            });
        }
        Ok(())
    }

    /// Stamps positions with the instant of a lockstep round (ns).
    pub(super) fn set_virtual_time(&mut self, now_ns: i64) {
        self.time = SendTime::Virtual(now_ns);
    }

    /// Stamps positions with the wall clock.
    pub(super) fn use_clock(&mut self, clock: WallClock) {
        self.time = SendTime::Wall(clock);
    }
}

impl PositionLink for LinkEndpoints {
    fn poll(&mut self) -> Result<Option<Position>, BusError> {
        while let Some(subscriber) = self.subscribers.get(self.next) {
            match subscriber
                .receive()
                .map_err(|e| BusError::failed("position", e))?
            {
                Some(sample) if self.hears.binary_search(&sample.from).is_ok() => {
                    return Ok(Some((*sample.payload()).into()));
                }
                // Neighbours share a service: this position is for another robot.
                Some(_) => {}
                None => self.next += 1,
            }
        }
        self.next = 0;
        Ok(None)
    }

    fn send(&mut self, position: &mut Position) -> Result<i64, BusError> {
        if self.publisher.is_none() {
            return Ok(position.tick_ns);
        }
        position.sent_ns = self.time.now_ns();
        self.forward(position)?;
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
