//! Endpoint for the links that cross from this host to another or come from there.

use slipstream_bus::message::{Position, RobotIndex};
use slipstream_bus::transport::BusError;

use crate::services::{PositionPublisher, PositionSubscriber, Services};

/// Ports for the positions that cross between hosts, on a host that has only some of the agents.
#[derive(Debug)]
pub struct CrossingLinks {
    /// Of each robot of this host that is heard on another: its positions.
    leaving: Vec<(RobotIndex, PositionSubscriber)>,
    /// Of each robot of another host that is heard on this one: where its positions are sent, and how many ports must
    /// receive one.
    entering: Vec<(RobotIndex, PositionPublisher, usize)>,
}

impl CrossingLinks {
    /// Opens the ports.
    ///
    /// # Errors
    /// A port cannot be created.
    pub fn new(services: &Services) -> Result<Self, BusError> {
        let mut links = Self {
            leaving: Vec::new(),
            entering: Vec::new(),
        };
        for robot in services.robots() {
            let receivers = services.topology().heard_by(robot);
            if services.is_leaving(robot) {
                let subscriber = services.position_subscriber(robot)?;
                links.leaving.push((robot, subscriber));
            }
            if !services.is_local(robot) && receivers.iter().any(|&to| services.is_local(to)) {
                let publisher = services.position_publisher(robot)?;
                // On the wall clock a full queue drops its oldest position.
                let required = match services.lockstep() {
                    true => services.position_receivers(robot),
                    false => 0,
                };
                links.entering.push((robot, publisher, required));
            }
        }
        Ok(links)
    }

    /// Calls `each` with every waiting position that leaves this host. Never blocks.
    ///
    /// # Errors
    /// The transport failed.
    pub fn poll(&self, mut each: impl FnMut(Position)) -> Result<(), BusError> {
        for (robot, subscriber) in &self.leaving {
            while let Some(sample) = subscriber
                .receive()
                .map_err(|e| BusError::failed("position", e))?
            {
                if sample.from == *robot {
                    each((*sample.payload()).into());
                }
            }
        }
        Ok(())
    }

    /// Hands a position from another host to its receiver. One that no robot of this host waits for is dropped.
    ///
    /// # Errors
    /// The transport failed, or a receiver's queue is full.
    pub fn deliver(&self, position: &Position) -> Result<(), BusError> {
        let entering = self
            .entering
            .iter()
            .find(|(from, ..)| *from == position.from);
        let Some((_, publisher, required)) = entering else {
            return Ok(());
        };
        let received = publisher
            .send_copy((*position).into())
            .map_err(|e| BusError::failed("position", e))?;
        if received < *required {
            return Err(BusError::QueueFull {
                what: "position".to_owned(),
            });
        }
        Ok(())
    }
}
