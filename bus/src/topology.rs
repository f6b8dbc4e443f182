//! Communication topology (directed chain or ring): which robot sends its position to which.

use crate::experiment::{Experiment, Protocol};
use crate::message::RobotIndex;

/// The links of an experiment: a chain from the front robot to the last one, which the `ring`
/// protocol closes to a ring. A single robot and robots in open loop have no links.
#[derive(Debug, Clone, Copy)]
pub struct Topology {
    robots: u32,
    ring: bool,
    linked: bool,
}

impl Topology {
    /// The topology of an experiment.
    pub fn new(experiment: &Experiment) -> Self {
        let settings = &experiment.settings;
        Self {
            robots: settings.robots.count,
            ring: settings.links.protocol == Protocol::Ring,
            linked: settings.robots.count > 1 && !settings.open_loop.enabled,
        }
    }

    /// The robot whose positions `robot` receives.
    pub fn predecessor(&self, robot: RobotIndex) -> Option<RobotIndex> {
        let last = self.ring.then_some(self.robots - 1);
        robot.checked_sub(1).or(last).filter(|_| self.linked)
    }

    /// The robot that receives the positions of `robot`.
    pub fn successor(&self, robot: RobotIndex) -> Option<RobotIndex> {
        let next = (robot + 1) % self.robots;
        Some(next).filter(|&next| self.linked && (self.ring || next != 0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topology(robots: u32, ring: bool, linked: bool) -> Topology {
        Topology {
            robots,
            ring,
            linked,
        }
    }

    #[test]
    fn the_ring_protocol_closes_the_chain() {
        let chain = topology(3, false, true);
        assert_eq!((chain.predecessor(0), chain.successor(2)), (None, None));
        assert_eq!(
            (chain.predecessor(2), chain.successor(0)),
            (Some(1), Some(1))
        );
        let ring = topology(3, true, true);
        assert_eq!((ring.predecessor(0), ring.successor(2)), (Some(2), Some(0)));
        let alone = topology(3, true, false);
        assert_eq!((alone.predecessor(1), alone.successor(1)), (None, None));
    }
}
