//! Delay line at the receiver of a link: delivers each message at its available time.

use serde::{Deserialize, Serialize};

use super::impairment::LinkImpairment;
use crate::message::Position;

/// Number of messages for which memory is reserved. The queue grows beyond it if necessary: where the delay is longer than
/// this many periods of the sender.
const INITIAL_CAPACITY: usize = 64;

/// Message counts of a link.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LinkCounts {
    /// Entered the delay line.
    pub received: u64,
    /// Left the delay line.
    pub delivered: u64,
    /// Lost by the impairment.
    pub lost: u64,
    /// Never entered the delay line, although a later one did: lost by the network between two hosts.
    pub missing: u64,
    /// Delivered after a position that was sampled later.
    pub stale: u64,
}

/// A message in the delay line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InFlight {
    /// The message.
    pub position: Position,
    /// When it leaves the delay line (ns).
    pub available_ns: i64,
}

/// Queue of the messages of a link, ordered by the time at which they become available.
#[derive(Debug)]
pub struct DelayLine {
    impairment: LinkImpairment,
    reorder: bool,
    /// By available time; messages of equal time in the order of sending.
    in_flight: Vec<InFlight>,
    /// From when on messages are delayed by how much more (ns), in the order of time.
    later_ns: Vec<(i64, i64)>,
    last_available_ns: i64,
    newest_sampled_ns: i64,
    /// Sequence number of the next message; `None` before the first.
    next_seq: Option<u32>,
    counts: LinkCounts,
}

/// A message that left the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// The message and its time.
    pub message: InFlight,
    /// A position that was sampled later has already been delivered.
    pub stale: bool,
}

impl DelayLine {
    /// An empty delay line. Without `reorder` no message overtakes an earlier one.
    pub fn new(impairment: LinkImpairment, reorder: bool) -> Self {
        Self {
            impairment,
            reorder,
            in_flight: Vec::with_capacity(INITIAL_CAPACITY),
            later_ns: Vec::new(),
            last_available_ns: 0,
            newest_sampled_ns: i64::MIN,
            next_seq: None,
            counts: LinkCounts::default(),
        }
    }

    /// The same, with messages sent from a time on delayed by so much more or less (ns). Times rise.
    #[must_use]
    pub fn with_later(self, later_ns: Vec<(i64, i64)>) -> Self {
        Self { later_ns, ..self }
    }

    /// How much more a message that is sent now is delayed (ns).
    fn more_ns(&self, sent_ns: i64) -> i64 {
        let begun = self.later_ns.partition_point(|own| own.0 <= sent_ns);
        let last = begun.checked_sub(1).and_then(|i| self.later_ns.get(i));
        last.map_or(0, |own| own.1)
    }

    /// Adds a message; to be called in the order of sending. Returns when the message becomes
    /// available (ns); `None` if it is lost.
    pub fn push(&mut self, position: Position) -> Option<i64> {
        self.counts.received += 1;
        let expected = self.next_seq.unwrap_or(position.seq);
        self.counts.missing += u64::from(position.seq.saturating_sub(expected));
        self.next_seq = Some(position.seq.wrapping_add(1));
        let Some(delay_ns) = self.impairment.draw() else {
            self.counts.lost += 1;
            return None;
        };
        let delay_ns = delay_ns
            .saturating_add(self.more_ns(position.sent_ns))
            .max(0);
        let mut available_ns = position.sent_ns.saturating_add(delay_ns);
        if !self.reorder {
            available_ns = available_ns.max(self.last_available_ns);
            self.last_available_ns = available_ns;
        }
        let index = self
            .in_flight
            .partition_point(|other| other.available_ns <= available_ns);
        self.in_flight.insert(
            index,
            InFlight {
                position,
                available_ns,
            },
        );
        Some(available_ns)
    }

    /// Removes and returns the next message that is available at `now_ns` and was sent before
    /// `now_ns`. A message sent at an instant is therefore never used at the same instant, so that
    /// all agents due at an instant can run in parallel.
    pub fn poll(&mut self, now_ns: i64) -> Option<Arrival> {
        let ready = |m: &InFlight| m.available_ns <= now_ns && m.position.sent_ns < now_ns;
        let index = self.in_flight.iter().position(ready)?;
        let message = self.in_flight.remove(index);
        let stale = message.position.sampled_ns < self.newest_sampled_ns;
        self.newest_sampled_ns = self.newest_sampled_ns.max(message.position.sampled_ns);
        self.counts.delivered += 1;
        self.counts.stale += u64::from(stale);
        Some(Arrival { message, stale })
    }

    /// The message counts so far.
    pub fn counts(&self) -> LinkCounts {
        self.counts
    }
}
