//! The hosts of a run, and how wrong their time stamps can be.

use std::collections::BTreeMap;

use slipstream_bus::message::RobotIndex;

use crate::step::Clock;
use crate::uncertainty::Uncertainty;

/// Where the agents run, and what is known of the clocks there. Empty for a run on one host.
#[derive(Debug, Clone, Default)]
pub(crate) struct Hosts {
    /// The host of each robot whose agent does not run on the host of the plant.
    of_robot: BTreeMap<RobotIndex, String>,
    /// The records of each host's clock.
    clocks: BTreeMap<String, HostClock>,
}

/// What is known of the clock of a host other than that of the plant.
#[derive(Debug, Clone, Default)]
pub(crate) struct HostClock {
    /// Largest error of a time stamp of the host at the time of each record, by that time (ns).
    errors_ns: BTreeMap<i64, i64>,
    /// Number of records.
    pub(crate) windows: u64,
    /// The last record.
    pub(crate) last: Option<Clock>,
    /// The last drift that is known, with the time of its record (10⁻⁹, ns).
    last_drift: Option<(i64, i64)>,
    /// Largest bound of the offset (ns).
    pub(crate) bound_ns: i64,
    /// Smallest round trip (ns).
    pub(crate) round_trip_ns: Option<i64>,
}

impl Hosts {
    /// The agent of a robot runs on a host.
    pub(crate) fn place(&mut self, robot: RobotIndex, host: String) {
        self.clocks.entry(host.clone()).or_default();
        self.of_robot.insert(robot, host);
    }

    /// Adds a record of a host's clock.
    pub(crate) fn add(&mut self, host: String, clock: &Clock) {
        self.clocks.entry(host).or_default().add(clock);
    }

    /// Names and clocks of the hosts, in the order of their names.
    pub(crate) fn clocks(&self) -> impl Iterator<Item = (&str, &HostClock)> {
        let clocks = self.clocks.iter();
        clocks.map(|(host, clock)| (host.as_str(), clock))
    }

    /// The robots whose agents run on a host.
    pub(crate) fn robots_on(&self, host: &str) -> impl Iterator<Item = RobotIndex> {
        let robots = self.of_robot.iter();
        robots.filter_map(move |(robot, own)| (own == host).then_some(*robot))
    }

    /// Whether the agents of two robots run on different hosts.
    pub(crate) fn are_apart(&self, one: RobotIndex, other: RobotIndex) -> bool {
        self.of_robot.get(&one) != self.of_robot.get(&other)
    }

    /// How wrong a time stamp of a robot's agent can be that reads `t_ns`.
    pub(crate) fn error(&self, robot: RobotIndex, t_ns: i64) -> Uncertainty {
        let Some(host) = self.of_robot.get(&robot) else {
            return Uncertainty::Exact;
        };
        let clock = self.clocks.get(host);
        let error_ns = clock.and_then(|clock| clock.error_ns(t_ns));
        error_ns.map_or(Uncertainty::Unknown, Uncertainty::Within)
    }
}

impl HostClock {
    fn add(&mut self, clock: &Clock) {
        let error_ns = clock.error_ns.max(0);
        let known_ns = self.errors_ns.entry(clock.t_ns).or_insert(error_ns);
        *known_ns = error_ns.max(*known_ns);
        self.windows += 1;
        if self.last.is_none_or(|last| last.t_ns <= clock.t_ns) {
            self.last = Some(*clock);
        }
        let drift = clock.drift_ppb.map(|drift_ppb| (clock.t_ns, drift_ppb));
        if drift.is_some_and(|(t_ns, _)| self.last_drift.is_none_or(|(last, _)| last <= t_ns)) {
            self.last_drift = drift;
        }
        self.bound_ns = self.bound_ns.max(clock.bound_ns);
        let shortest_ns = self.round_trip_ns.unwrap_or(i64::MAX);
        self.round_trip_ns = Some(shortest_ns.min(clock.round_trip_ns));
    }

    /// The last drift that is known (10⁻⁹).
    pub(crate) fn drift_ppb(&self) -> Option<i64> {
        self.last_drift.map(|(_, drift_ppb)| drift_ppb)
    }

    /// Largest error of a time stamp that reads `t_ns`: the larger one of the records before and after;
    /// `None` without any record (ns).
    fn error_ns(&self, t_ns: i64) -> Option<i64> {
        let before = self.errors_ns.range(..=t_ns).next_back();
        let after = self.errors_ns.range(t_ns..).next();
        let errors = before.into_iter().chain(after);
        errors.map(|(_, error_ns)| *error_ns).max()
    }

    /// Largest error of any time stamp from time 0 on (ns).
    pub(crate) fn largest_error_ns(&self) -> Option<i64> {
        let after = self.errors_ns.range(0..).map(|(_, error_ns)| *error_ns);
        after.chain(self.error_ns(0)).max()
    }
}
