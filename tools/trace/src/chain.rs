//! Cause-effect chains: one message from the encoder sample behind it to the torque that results
//! from it.

use std::collections::BTreeMap;

use slipstream_bus::message::RobotIndex;
use slipstream_bus::record::Fate as LinkFate;

use crate::log::{Key, Later, Log, Sent, Tick};
use crate::uncertainty::Uncertainty;

/// The stages in the order of the chain.
pub const STAGES: [&str; 7] = [
    "sample_wait",
    "compute",
    "transport",
    "injected_delay",
    "outer_wait",
    "inner_wait",
    "apply_wait",
];

/// A message and what became of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TracedMessage {
    /// The sender.
    pub from: RobotIndex,
    /// The receiver.
    pub to: RobotIndex,
    /// Sequence number, counted by the sender.
    pub seq: u32,
    /// Delay on the link: from sending until the delay line released it (ns), whether it was used or
    /// not; `None` if it was lost or the recording does not say.
    pub delay_ns: Option<i64>,
    /// What became of it.
    pub fate: Fate,
}

/// What became of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// A torque results from it.
    Used(Chain),
    /// The link lost it.
    Lost,
    /// A newer message left the delay line at the same tick.
    Superseded,
    /// A newer message had arrived before.
    Stale,
    /// An outer tick used it, but a newer tick replaced that tick's set-points before any torque.
    Overwritten,
    /// The recording ends before the chain is complete.
    UnderWay,
    /// The receiver's process died before it used the message.
    Died,
    /// Records of its chain are missing.
    Untold,
}

/// The instants of a complete cause-effect chain (ns of the run's clock).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chain {
    /// Encoders read, sender's outer tick, sent, through the bus, released by the delay line,
    /// receiver's outer tick, receiver's inner tick, plant step. The first and the last are on the clock
    /// of the plant's host, the others on those of the sender's and of the receiver's.
    pub instants_ns: [i64; 8],
    /// By how much each stage can be wrong because it ends on another host than it begins, in the order
    /// of [`STAGES`]. A stage that is shorter than this may be negative.
    pub uncertainty: [Uncertainty; 7],
}

impl TracedMessage {
    /// The link it was sent on.
    pub(crate) fn link(&self) -> Link {
        (self.from, self.to)
    }
}

impl Chain {
    /// Duration of each stage (ns), in the order of [`STAGES`].
    pub fn stages_ns(&self) -> [i64; 7] {
        let mut stages = [0; 7];
        for (stage, pair) in stages.iter_mut().zip(self.instants_ns.windows(2)) {
            *stage = pair[1].saturating_sub(pair[0]);
        }
        stages
    }

    /// From the encoder sample to the plant step (ns).
    pub fn end_to_end_ns(&self) -> i64 {
        self.instants_ns[7].saturating_sub(self.instants_ns[0])
    }
}

/// A link: sender and receiver.
pub(crate) type Link = (RobotIndex, RobotIndex);

/// Groups items by link.
pub(crate) fn by_link<T>(items: impl IntoIterator<Item = (Link, T)>) -> BTreeMap<Link, Vec<T>> {
    let mut links: BTreeMap<Link, Vec<T>> = BTreeMap::new();
    for (link, item) in items {
        links.entry(link).or_default().push(item);
    }
    links
}

/// Every message of a run, ordered by link and sequence number, with what became of it.
pub fn follow(log: &Log) -> Vec<TracedMessage> {
    messages(log).collect()
}

/// As [`follow`], one after the other.
pub(crate) fn messages(log: &Log) -> impl Iterator<Item = TracedMessage> {
    log.messages().map(|key| message(log, key))
}

fn message(log: &Log, key: Key) -> TracedMessage {
    let (from, to, seq) = key;
    let sent = log.sent(key);
    let fate = sent.map_or(Fate::Untold, |sent| fate(log, key, &sent));
    let available_ns = log.arrived(key).flatten();
    let sent_and_available = sent.zip(available_ns);
    TracedMessage {
        from,
        to,
        seq,
        delay_ns: sent_and_available
            .map(|(sent, available_ns)| available_ns.saturating_sub(sent.sent_ns)),
        fate,
    }
}

/// What became of a message that was sent.
fn fate(log: &Log, key: Key, sent: &Sent) -> Fate {
    let available_ns = match log.arrived(key) {
        None => return unarrived(log, key, sent),
        Some(None) => return Fate::Lost,
        Some(Some(available_ns)) => available_ns,
    };
    match log.taken(key) {
        None => unfinished(log, sent),
        Some((_, LinkFate::Unused)) => Fate::UnderWay,
        Some((_, LinkFate::Stale)) => Fate::Stale,
        Some((_, LinkFate::Superseded)) => Fate::Superseded,
        Some((tick_ns, LinkFate::Used)) => chain(log, key, sent, available_ns, tick_ns),
    }
}

/// Follows a message that an outer tick used on to the torque. `available_ns`: when the delay line
/// released it; `tick_ns`: when the outer tick was due.
fn chain(log: &Log, key: Key, sent: &Sent, available_ns: i64, tick_ns: i64) -> Fate {
    let (from, ..) = key;
    let outer = (sent.to, tick_ns);
    let ticks = (log.outer((from, sent.tick_ns)), log.outer(outer));
    let (Some(sender_tick), Some(receiver_tick)) = ticks else {
        return Fate::Untold;
    };
    let overwritten_if = |newer: bool| {
        if newer {
            Fate::Overwritten
        } else {
            unfinished(log, sent)
        }
    };
    let inner_ns = match log.first_inner(outer) {
        Ok(inner_ns) => inner_ns,
        Err(Later(newer)) => return overwritten_if(newer),
    };
    let inner = (sent.to, inner_ns);
    let applied_ns = match log.applied(inner) {
        Ok(applied_ns) => applied_ns,
        Err(Later(newer)) => return overwritten_if(newer),
    };
    let Some(inner_tick) = log.inner(inner) else {
        return Fate::Untold;
    };
    // When a message between two hosts came out of the network, only the receiver's host knows.
    let crossed_ns = log.crossed(key);
    let are_apart = log.hosts.are_apart(from, sent.to);
    let through_ns = match crossed_ns {
        Some(crossed_ns) => crossed_ns,
        None if are_apart => return Fate::Untold,
        None => sent.queued_ns,
    };
    // A message that the tick used was through the bus, even if the process that says so was suspended
    // before it could record it. That process is on the tick's own host, or both robots are on one.
    let queued_ns = through_ns.min(receiver_tick.began_ns);
    let instants_ns = [
        sent.sampled_ns,
        sender_tick.began_ns,
        sent.sent_ns,
        queued_ns,
        available_ns.max(queued_ns),
        receiver_tick.began_ns,
        inner_tick.began_ns,
        applied_ns,
    ];
    let error = |robot, t_ns| log.hosts.error(robot, t_ns);
    let mut uncertainty = [Uncertainty::Exact; 7];
    uncertainty[0] = error(from, sender_tick.began_ns);
    uncertainty[2] = if are_apart {
        error(from, sent.sent_ns).plus(error(sent.to, queued_ns))
    } else if crossed_ns.is_some() {
        // The recording does not tell the hosts of its robots.
        Uncertainty::Unknown
    } else {
        Uncertainty::Exact
    };
    uncertainty[6] = error(sent.to, inner_tick.began_ns);
    Fate::Used(Chain {
        instants_ns,
        uncertainty,
    })
}

/// Why a message did not arrive. The network between two hosts keeps the order of messages, but may lose some.
fn unarrived(log: &Log, key: Key, sent: &Sent) -> Fate {
    match unfinished(log, sent) {
        Fate::UnderWay if log.hosts.are_apart(key.0, sent.to) && log.arrived_after(key) => {
            Fate::Lost
        }
        fate => fate,
    }
}

/// Why a chain stops before a torque: its receiver died, or the recording ends.
fn unfinished(log: &Log, sent: &Sent) -> Fate {
    let died = |&(robot, t_ns): &Tick| robot == sent.to && t_ns >= sent.sent_ns;
    if log.deaths.iter().any(died) {
        Fate::Died
    } else {
        Fate::UnderWay
    }
}
