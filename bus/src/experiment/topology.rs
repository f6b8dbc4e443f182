//! Communication topology: which robot hears which.

use super::hears::Hears;
use super::settings::{Protocol, Settings};
use super::setup::Experiment;
use crate::error::InputError;
use crate::message::{RobotIndex, robot_name};
use crate::range::invalid;

/// Largest number of links of a run.
const MAX_LINKS: usize = 100_000;

/// The links of an experiment. A single robot and robots in open loop have none.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topology {
    /// Of each robot those that it hears, in order.
    hears: Vec<Vec<RobotIndex>>,
    /// Of each robot those that hear it, in order.
    heard_by: Vec<Vec<RobotIndex>>,
    /// Whether a token goes around.
    ring: bool,
}

impl Topology {
    /// The topology of an experiment with valid settings.
    pub fn new(experiment: &Experiment) -> Self {
        Self::of(&experiment.settings)
    }

    /// The topology of valid settings. Links that name robots which do not exist are left out.
    pub fn of(settings: &Settings) -> Self {
        let robots = settings.robots.count as usize;
        let mut topology = Self {
            hears: vec![Vec::new(); robots],
            heard_by: vec![Vec::new(); robots],
            ring: settings.links.protocol == Protocol::Ring,
        };
        if robots > 1 && !settings.open_loop.enabled {
            for (from, to) in links(settings) {
                topology.add(from, to);
            }
        }
        topology
    }

    fn add(&mut self, from: RobotIndex, to: RobotIndex) {
        let last = RobotIndex::try_from(self.hears.len()).unwrap_or(RobotIndex::MAX);
        if from >= last || to >= last {
            return;
        }
        let hears = &mut self.hears[to as usize];
        if let Err(place) = hears.binary_search(&from) {
            hears.insert(place, from);
            let heard_by = &mut self.heard_by[from as usize];
            let place = heard_by.partition_point(|&other| other < to);
            heard_by.insert(place, to);
        }
    }

    /// The robots that `robot` hears, in order.
    pub fn hears(&self, robot: RobotIndex) -> &[RobotIndex] {
        self.hears.get(robot as usize).map_or(&[], Vec::as_slice)
    }

    /// The robots that hear `robot`, in order.
    pub fn heard_by(&self, robot: RobotIndex) -> &[RobotIndex] {
        self.heard_by.get(robot as usize).map_or(&[], Vec::as_slice)
    }

    /// Whether `to` hears `from`.
    pub fn is_link(&self, from: RobotIndex, to: RobotIndex) -> bool {
        self.hears(to).binary_search(&from).is_ok()
    }

    /// The robot whose path `robot` follows: the one ahead of it, if it hears that one.
    pub fn predecessor(&self, robot: RobotIndex) -> Option<RobotIndex> {
        let ahead = robot.checked_sub(1)?;
        self.is_link(ahead, robot).then_some(ahead)
    }

    /// In a token ring: the robot after whose position this one sends.
    pub fn token_from(&self, robot: RobotIndex) -> Option<RobotIndex> {
        let last = RobotIndex::try_from(self.hears.len())
            .ok()?
            .checked_sub(1)?;
        let before = robot.checked_sub(1).unwrap_or(last);
        (self.ring && self.is_link(before, robot)).then_some(before)
    }
}

/// Sender and receiver of every link, some perhaps twice.
fn links(settings: &Settings) -> Vec<(RobotIndex, RobotIndex)> {
    let count = settings.robots.count;
    let token_ring = settings.links.protocol == Protocol::Ring;
    let chain = (1..count).map(|to| (to - 1, to));
    let closing = std::iter::once((count - 1, 0));
    let closed = match &settings.links.topology {
        Hears::Ring => true,
        Hears::Links(_) => false,
        _ => token_ring,
    };
    let mut all: Vec<(RobotIndex, RobotIndex)> = match &settings.links.topology {
        Hears::Predecessor | Hears::Ring => chain.collect(),
        Hears::LeaderPredecessor => {
            let leader = (1..count).map(|to| (0, to));
            chain.chain(leader).collect()
        }
        Hears::TwoPredecessors => {
            let second = (2..count).map(|to| (to - 2, to));
            chain.chain(second).collect()
        }
        Hears::All => {
            let pairs = (0..count).flat_map(|from| (0..count).map(move |to| (from, to)));
            pairs.filter(|(from, to)| from != to).collect()
        }
        Hears::Links(own) => own.iter().map(|&[from, to]| (from, to)).collect(),
    };
    all.extend(closing.filter(|_| closed));
    all
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
    for (index, &[from, to]) in own.iter().enumerate() {
        let link = format!("{}>{}", robot_name(from), robot_name(to));
        if from.max(to) >= count {
            let robot = robot_name(from.max(to));
            let remedy = format!("give r1 to {}", robot_name(count - 1));
            return invalid(key, format!("names {robot}, which does not exist"), remedy);
        }
        if from == to {
            return invalid(key, format!("has the link {link}"), "leave it out");
        }
        if own
            .get(..index)
            .is_some_and(|before| before.contains(&[from, to]))
        {
            return invalid(key, format!("has {link} twice"), "leave one out");
        }
    }
    let topology = Topology::of(settings);
    let lacking = (0..count).find(|&robot| topology.token_from(robot).is_none());
    if let Some(robot) =
        lacking.filter(|_| topology.ring && count > 1 && !settings.open_loop.enabled)
    {
        let before = robot.checked_sub(1).unwrap_or(count - 1);
        let link = format!("{}>{}", robot_name(before), robot_name(robot));
        let remedy = "add it, or set links.protocol = \"periodic\"";
        return invalid(
            key,
            format!("lacks {link}, on which the token goes around"),
            remedy,
        );
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
        assert_eq!((chain.hears(2), chain.heard_by(0)), (&[1][..], &[1][..]));
        assert_eq!((chain.predecessor(1), chain.token_from(1)), (Some(0), None));
        let ring = Topology::of(&settings(3, Protocol::Ring, "predecessor"));
        assert_eq!((ring.hears(0), ring.heard_by(2)), (&[2][..], &[0][..]));
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
