//! Communication topology: which robot hears which.

use std::collections::BTreeSet;

use super::hears::Hears;
use super::settings::{Protocol, Settings};
use super::setup::Experiment;
use crate::error::InputError;
use crate::message::{RobotIndex, robot_name};
use crate::range::invalid;

/// Largest number of links of a run.
const MAX_LINKS: usize = 100_000;

/// The links of an experiment. A single robot and robots in open loop have none.
///
/// It is cheap to make: the neighbours of a robot are found when they are asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topology {
    robots: u32,
    hears: Hears,
    /// Whether a token goes around.
    ring: bool,
    /// Whether there are links at all.
    linked: bool,
}

impl Topology {
    /// The topology of an experiment with valid settings.
    pub fn new(experiment: &Experiment) -> Self {
        Self::of(&experiment.settings)
    }

    /// The topology of valid settings.
    pub fn of(settings: &Settings) -> Self {
        Self {
            robots: settings.robots.count,
            hears: settings.links.topology.clone(),
            ring: settings.links.protocol == Protocol::Ring,
            linked: settings.robots.count > 1 && !settings.open_loop.enabled,
        }
    }

    /// Whether `to` hears `from`.
    pub fn is_link(&self, from: RobotIndex, to: RobotIndex) -> bool {
        if !self.linked || from == to || from.max(to) >= self.robots {
            return false;
        }
        // What a list lacks, it lacks on purpose.
        let closes = self.ring || self.hears == Hears::Ring;
        let closing = closes && (from, to) == (self.robots - 1, 0);
        match &self.hears {
            Hears::Predecessor | Hears::Ring => from + 1 == to || closing,
            Hears::LeaderPredecessor => from == 0 || from + 1 == to || closing,
            Hears::TwoPredecessors => from + 1 == to || from + 2 == to || closing,
            Hears::All => true,
            Hears::Links(own) => own.contains(&[from, to]),
        }
    }

    /// The robots that `robot` hears, in order.
    pub fn hears(&self, robot: RobotIndex) -> Vec<RobotIndex> {
        self.neighbours(robot, |other| self.is_link(other, robot))
    }

    /// The robots that hear `robot`, in order.
    pub fn heard_by(&self, robot: RobotIndex) -> Vec<RobotIndex> {
        self.neighbours(robot, |other| self.is_link(robot, other))
    }

    /// The robots that are linked with `robot` in one direction, in order.
    fn neighbours(
        &self,
        robot: RobotIndex,
        is_linked: impl Fn(RobotIndex) -> bool,
    ) -> Vec<RobotIndex> {
        let mut others: Vec<RobotIndex> = match &self.hears {
            Hears::All => (0..self.robots).collect(),
            Hears::LeaderPredecessor if robot == 0 => (0..self.robots).collect(),
            Hears::Links(own) => {
                let own = own.iter().filter(|link| link.contains(&robot));
                own.flatten().copied().collect()
            }
            // Nobody hears further than two robots, but for the ends of the platoon.
            _ => {
                let near = robot.saturating_sub(2)..=robot.saturating_add(2);
                [0, self.robots.saturating_sub(1)]
                    .into_iter()
                    .chain(near)
                    .collect()
            }
        };
        others.retain(|&other| is_linked(other));
        others.sort_unstable();
        others.dedup();
        others
    }

    /// The robot whose path `robot` follows: the one ahead of it, if it hears that one.
    pub fn predecessor(&self, robot: RobotIndex) -> Option<RobotIndex> {
        let ahead = robot.checked_sub(1)?;
        self.is_link(ahead, robot).then_some(ahead)
    }

    /// In a token ring: the robot after whose position this one sends.
    pub fn token_from(&self, robot: RobotIndex) -> Option<RobotIndex> {
        let before = robot.checked_sub(1).or(self.robots.checked_sub(1))?;
        (self.ring && self.is_link(before, robot)).then_some(before)
    }
}

/// Checks the links of settings whose number of robots is valid.
///
/// # Errors
/// A link of a robot to itself, to one that does not exist, or given twice; a token ring that is not closed; more links
/// than a run can have.
pub(super) fn validate(settings: &Settings) -> Result<(), InputError> {
    let key = "links.topology";
    let count = settings.robots.count;
    if settings.links.topology == Hears::All && count as usize * count as usize > MAX_LINKS {
        let problem = format!("is all: {count} robots have more than {MAX_LINKS} links");
        return invalid(key, problem, "run fewer robots, or give another topology");
    }
    let Hears::Links(own) = &settings.links.topology else {
        return Ok(());
    };
    if own.len() > MAX_LINKS {
        let problem = format!("has more than {MAX_LINKS} links");
        return invalid(key, problem, "give fewer");
    }
    let mut links = BTreeSet::new();
    for &[from, to] in own {
        let link = format!("{}>{}", robot_name(from), robot_name(to));
        if from.max(to) >= count {
            let robot = robot_name(from.max(to));
            let remedy = format!("give r1 to {}", robot_name(count - 1));
            return invalid(key, format!("names {robot}, which does not exist"), remedy);
        }
        if from == to {
            return invalid(key, format!("has the link {link}"), "leave it out");
        }
        if !links.insert([from, to]) {
            return invalid(key, format!("has {link} twice"), "leave one out");
        }
    }
    let topology = Topology::of(settings);
    let around = (0..count).map(|robot| [robot.checked_sub(1).unwrap_or(count - 1), robot]);
    let mut lacking = around.filter(|link| !links.contains(link));
    if topology.ring
        && topology.linked
        && let Some([from, to]) = lacking.next()
    {
        let link = format!("{}>{}", robot_name(from), robot_name(to));
        let remedy = "add it, or set links.protocol = \"periodic\"";
        let problem = format!("lacks {link}, on which the token goes around");
        return invalid(key, problem, remedy);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(robots: u32, protocol: Protocol, topology: &str) -> Settings {
        let mut settings = Settings::default();
        settings.robots.count = robots;
        settings.links.protocol = protocol;
        settings.links.topology = topology.parse().unwrap();
        settings
    }

    #[test]
    fn the_ring_protocol_closes_the_chain() {
        let chain = Topology::of(&settings(3, Protocol::Periodic, "predecessor"));
        assert!(chain.hears(0).is_empty() && chain.heard_by(2).is_empty());
        assert_eq!((chain.hears(2), chain.heard_by(0)), (vec![1], vec![1]));
        assert_eq!((chain.predecessor(1), chain.token_from(1)), (Some(0), None));
        let ring = Topology::of(&settings(3, Protocol::Ring, "predecessor"));
        assert_eq!((ring.hears(0), ring.heard_by(2)), (vec![2], vec![0]));
        assert_eq!((ring.predecessor(0), ring.token_from(0)), (None, Some(2)));
        let alone = Topology::of(&settings(1, Protocol::Ring, "all"));
        assert!(alone.hears(0).is_empty());
    }

    #[test]
    fn every_topology_has_its_links() {
        let of = |name| Topology::of(&settings(4, Protocol::Periodic, name));
        assert_eq!(of("leader_predecessor").hears(3), [0, 2]);
        assert_eq!(of("leader_predecessor").heard_by(0), [1, 2, 3]);
        assert_eq!(of("two_predecessors").hears(3), [1, 2]);
        assert_eq!(of("two_predecessors").hears(1), [0]);
        assert_eq!(of("ring").hears(0), [3]);
        assert_eq!(of("all").hears(1), [0, 2, 3]);
        assert_eq!(of("r1>r3 r3>r1").hears(2), [0]);
        assert_eq!(of("r1>r3 r3>r1").predecessor(2), None);
    }

    #[test]
    fn neighbours_are_those_of_all_pairs() {
        for protocol in [Protocol::Ring, Protocol::Periodic] {
            for name in [
                "predecessor",
                "leader_predecessor",
                "two_predecessors",
                "ring",
                "all",
                "r7>r1 r2>r6 r6>r2",
            ] {
                for robots in 1..8 {
                    let topology = Topology::of(&settings(robots, protocol, name));
                    for robot in 0..robots {
                        let all = || 0..robots;
                        let hears: Vec<u32> = all()
                            .filter(|&from| topology.is_link(from, robot))
                            .collect();
                        let heard_by: Vec<u32> =
                            all().filter(|&to| topology.is_link(robot, to)).collect();
                        assert_eq!(topology.hears(robot), hears, "{name} {robots}");
                        assert_eq!(topology.heard_by(robot), heard_by, "{name} {robots}");
                    }
                }
            }
        }
    }

    #[test]
    fn links_that_cannot_be_are_refused_with_a_remedy() {
        let problem = |protocol, links| {
            let settings = settings(3, protocol, links);
            validate(&settings).err().map(|error| error.problem)
        };
        assert_eq!(problem(Protocol::Periodic, "r1>r2 r2>r3"), None);
        assert_eq!(problem(Protocol::Ring, "r1>r2 r2>r3 r3>r1"), None);
        for (protocol, links, expected) in [
            (Protocol::Periodic, "r1>r4", "names r4"),
            (Protocol::Periodic, "r2>r2", "has the link r2>r2"),
            (Protocol::Periodic, "r1>r2 r1>r2", "has r1>r2 twice"),
            (Protocol::Ring, "r1>r2 r2>r3", "lacks r3>r1"),
        ] {
            let found = problem(protocol, links).unwrap();
            assert!(found.contains(expected), "{found}");
        }
    }
}
