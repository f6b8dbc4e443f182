//! The links of a node: delay line of each incoming one, token ring protocol of the outgoing ones.

use slipstream_bus::experiment::{Experiment, Protocol};
use slipstream_bus::link::{DelayLine, LinkCounts, LinkImpairment};
use slipstream_bus::message::{Position, RobotIndex};
use slipstream_bus::record::{Fate, Recorder};
use slipstream_bus::time::ns_from_s;

use super::log;

/// The link from a robot that is heard.
#[derive(Debug)]
pub(super) struct Incoming {
    from: RobotIndex,
    to: RobotIndex,
    line: DelayLine,
    /// Whether a fresh position arrived since the last sending.
    pub(super) fresh: bool,
    /// Token round of the last position.
    pub(super) token_round: u32,
}

impl Incoming {
    /// The link `from` → `to` of an experiment.
    pub(super) fn new(experiment: &Experiment, from: RobotIndex, to: RobotIndex) -> Self {
        let settings = &experiment.settings;
        let links = &settings.links;
        let half_round_trips_ns = &experiment.half_round_trips_ns;
        let impairment = LinkImpairment::new(links, half_round_trips_ns, settings.seed, from, to);
        Self {
            from,
            to,
            line: DelayLine::new(impairment, links.reorder)
                .with_later(settings.later_ns([from, to])),
            fresh: false,
            token_round: 0,
        }
    }

    /// Puts a position that has come from the transport into the delay line.
    pub(super) fn push(&mut self, position: &Position, recorder: &mut impl Recorder) {
        let available_ns = self.line.push(*position);
        log::arrived([self.from, self.to], position, available_ns, recorder);
    }

    /// The sender.
    pub(super) fn from(&self) -> RobotIndex {
        self.from
    }

    /// Removes all available positions from the delay line and returns the one that was sampled
    /// last, if it is newer than all before.
    pub(super) fn poll_newest(
        &mut self,
        now_ns: i64,
        recorder: &mut impl Recorder,
    ) -> Option<Position> {
        let link = [self.from, self.to];
        let mut newest: Option<Position> = None;
        while let Some(arrival) = self.line.poll(now_ns) {
            let position = arrival.message.position;
            if arrival.stale {
                log::taken(link, position.seq, now_ns, Fate::Stale, recorder);
            } else if let Some(older) = newest.replace(position) {
                log::taken(link, older.seq, now_ns, Fate::Superseded, recorder);
            }
        }
        let position = newest?;
        log::taken(link, position.seq, now_ns, Fate::Used, recorder);
        self.fresh = true;
        self.token_round = position.token_round;
        Some(position)
    }

    /// Removes the positions that became available after the last outer tick.
    pub(super) fn drain_delay_line(&mut self, now_ns: i64, recorder: &mut impl Recorder) {
        while let Some(arrival) = self.line.poll(now_ns) {
            let seq = arrival.message.position.seq;
            log::taken([self.from, self.to], seq, now_ns, Fate::Unused, recorder);
        }
    }

    /// The sender, and the message counts so far.
    pub(super) fn counts(&self) -> (RobotIndex, LinkCounts) {
        (self.from, self.line.counts())
    }
}

/// The links to those that hear the robot. One message goes to all of them.
#[derive(Debug, Clone)]
pub(super) struct Outgoing {
    /// The receivers.
    pub(super) to: Vec<RobotIndex>,
    protocol: Protocol,
    /// Time without a return after which the front robot starts a new token round (ns).
    timeout_ns: i64,
    /// Sequence number of the next position.
    pub(super) seq: u32,
    /// Token round of the last position.
    pub(super) token_round: u32,
    /// Outer tick at which the last position was sent (ns).
    last_sent_ns: Option<i64>,
}

impl Outgoing {
    /// The links to the robots `to` of an experiment.
    pub(super) fn new(experiment: &Experiment, to: Vec<RobotIndex>) -> Self {
        let settings = &experiment.settings;
        let links = &settings.links;
        let expected_ns = settings.expected_token_round_ns(experiment.longest_trace_ns());
        Self {
            to,
            protocol: links.protocol,
            timeout_ns: expected_ns + ns_from_s(links.ring_timeout_s),
            seq: 0,
            token_round: 0,
            last_sent_ns: None,
        }
    }

    /// The token round for which `robot` sends at an outer tick; `None` if it does not send. `incoming` is the link on which the
    /// token comes.
    ///
    /// `periodic`: every robot sends at every tick. `ring`: the front robot sends when its last
    /// token round has returned or is overdue, every other robot when a fresh position has arrived.
    pub(super) fn round_to_send(
        &self,
        robot: RobotIndex,
        incoming: Option<&Incoming>,
        now_ns: i64,
    ) -> Option<u32> {
        let fresh = incoming.filter(|incoming| incoming.fresh);
        match (self.protocol, robot, self.last_sent_ns) {
            (Protocol::Periodic, _, _) | (Protocol::Ring, 0, None) => Some(0),
            (Protocol::Ring, 0, Some(last_sent_ns)) => {
                let returned = incoming.is_some_and(|incoming| self.has_returned(incoming));
                let overdue = now_ns - last_sent_ns >= self.timeout_ns;
                (returned || overdue).then_some(self.token_round + 1)
            }
            (Protocol::Ring, _, _) => fresh.map(|link| link.token_round),
        }
    }

    /// Whether the front robot starts a new token round although the last one has not returned.
    pub(super) fn restarts_ring(&self, robot: RobotIndex, incoming: &Incoming) -> bool {
        robot == 0 && self.last_sent_ns.is_some() && !self.has_returned(incoming)
    }

    /// Whether a fresh position of the last token round has arrived.
    fn has_returned(&self, incoming: &Incoming) -> bool {
        incoming.fresh && incoming.token_round == self.token_round
    }

    /// Counts a position that was sent for a token round at the outer tick `now_ns`.
    pub(super) fn count_sent(&mut self, token_round: u32, now_ns: i64) {
        self.seq += 1;
        self.token_round = token_round;
        self.last_sent_ns = Some(now_ns);
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::{RobotModel, Settings};

    use super::*;

    fn experiment(protocol: Protocol) -> Experiment {
        let mut settings = Settings::default();
        settings.links.protocol = protocol;
        Experiment::new(settings, &RobotModel::default())
    }

    #[test]
    fn the_front_robot_sends_again_when_its_token_round_returns_or_is_overdue() {
        let experiment = experiment(Protocol::Ring);
        let mut incoming = Incoming::new(&experiment, 2, 0);
        let mut outgoing = Outgoing::new(&experiment, vec![1]);
        assert_eq!(outgoing.round_to_send(0, Some(&incoming), 0), Some(0));
        outgoing.count_sent(0, 0);
        assert_eq!(outgoing.round_to_send(0, Some(&incoming), 50_000_000), None);
        incoming.fresh = true;
        assert!(!outgoing.restarts_ring(0, &incoming));
        let returned = outgoing.round_to_send(0, Some(&incoming), 50_000_000);
        assert_eq!(returned, Some(1));
        // Three links of one outer period each, and links.ring_timeout_s.
        incoming.fresh = false;
        let at = |now_ns| outgoing.round_to_send(0, Some(&incoming), now_ns);
        assert_eq!((at(600_000_000), at(650_000_000)), (None, Some(1)));
        assert!(outgoing.restarts_ring(0, &incoming));
    }

    #[test]
    fn a_follower_passes_the_token_on_once() {
        let experiment = experiment(Protocol::Ring);
        let mut incoming = Incoming::new(&experiment, 0, 1);
        let outgoing = Outgoing::new(&experiment, vec![2]);
        assert_eq!(outgoing.round_to_send(1, Some(&incoming), 0), None);
        (incoming.fresh, incoming.token_round) = (true, 4);
        assert_eq!(outgoing.round_to_send(1, Some(&incoming), 0), Some(4));
    }

    #[test]
    fn the_periodic_protocol_sends_at_every_tick() {
        let experiment = experiment(Protocol::Periodic);
        let mut outgoing = Outgoing::new(&experiment, vec![1]);
        assert_eq!(outgoing.round_to_send(0, None, 0), Some(0));
        outgoing.count_sent(0, 0);
        assert_eq!(outgoing.round_to_send(0, None, 50_000_000), Some(0));
    }
}
