//! One message's way from the encoder sample behind it to the torque that answers it.

use std::collections::BTreeMap;
use std::ops::Bound::{Excluded, Included};

use slipstream_bus::message::RobotIndex;
use slipstream_bus::record::Fate as Ending;

use crate::log::{Key, Log, Sent, Tick};

/// The stages in the order of the way.
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
pub struct Message {
    /// The sender.
    pub from: RobotIndex,
    /// The receiver.
    pub to: RobotIndex,
    /// Counts the sender's messages.
    pub seq: u32,
    /// What the link added, from sending until the delay line gave it out (ns), used or not; `None`
    /// where it was lost or the recording does not say.
    pub delay_ns: Option<i64>,
    /// What became of it.
    pub fate: Fate,
}

/// What became of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// A torque answers it.
    Used(Way),
    /// The link lost it.
    Lost,
    /// A newer one left the delay line at the same tick.
    Superseded,
    /// A newer one had come before.
    Stale,
    /// An outer tick used it, but a newer tick came before any torque.
    Overwritten,
    /// The recording ends before its way does.
    UnderWay,
    /// The receiver's process died before it took the message up.
    Died,
    /// Records of its way are missing.
    Untold,
}

/// The instants of a complete way (ns of the run's clock).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Way {
    /// Encoders read, the sender's outer tick, sent, through the bus, out of the delay line, the
    /// receiver's outer tick, its inner tick, the plant's step.
    pub instants_ns: [i64; 8],
}

impl Message {
    /// Its link.
    pub(crate) fn link(&self) -> Link {
        (self.from, self.to)
    }
}

impl Way {
    /// How long each stage took (ns), in the order of [`STAGES`].
    pub fn stages_ns(&self) -> [i64; 7] {
        let mut stages = [0; 7];
        for (stage, pair) in stages.iter_mut().zip(self.instants_ns.windows(2)) {
            *stage = pair[1].saturating_sub(pair[0]);
        }
        stages
    }

    /// From the encoder sample to the plant's step (ns).
    pub fn end_to_end_ns(&self) -> i64 {
        self.instants_ns[7].saturating_sub(self.instants_ns[0])
    }
}

/// A link: sender and receiver.
pub(crate) type Link = (RobotIndex, RobotIndex);

/// What belongs to each link.
pub(crate) fn by_link<T>(items: impl IntoIterator<Item = (Link, T)>) -> BTreeMap<Link, Vec<T>> {
    let mut links: BTreeMap<Link, Vec<T>> = BTreeMap::new();
    for (link, item) in items {
        links.entry(link).or_default().push(item);
    }
    links
}

/// Every message of a run, by sender and number, with what became of it.
pub fn follow(log: &Log) -> Vec<Message> {
    let keys = log.sent.keys().chain(log.arrived.keys());
    let keys: BTreeMap<Key, ()> = keys.map(|key| (*key, ())).collect();
    keys.into_keys().map(|key| message(log, key)).collect()
}

fn message(log: &Log, key: Key) -> Message {
    let (from, seq) = key;
    let sent = log.sent.get(&key);
    let arrived_at = log.arrived.get(&key).map(|(to, _)| *to);
    let to = sent.map(|sent| sent.to).or(arrived_at).unwrap_or(from);
    let fate = sent.map_or(Fate::Untold, |sent| fate(log, key, sent));
    let available_ns = log.arrived.get(&key).and_then(|(_, available)| *available);
    let times = sent.zip(available_ns);
    Message {
        from,
        to,
        seq,
        delay_ns: times.map(|(sent, available_ns)| available_ns.saturating_sub(sent.sent_ns)),
        fate,
    }
}

fn fate(log: &Log, key: Key, sent: &Sent) -> Fate {
    let unfinished = || {
        let died = |&(robot, t_ns): &Tick| robot == sent.to && t_ns >= sent.sent_ns;
        if log.deaths.iter().any(died) {
            Fate::Died
        } else {
            Fate::UnderWay
        }
    };
    let available_ns = match log.arrived.get(&key) {
        None => return unfinished(),
        Some((_, None)) => return Fate::Lost,
        Some((_, Some(available_ns))) => *available_ns,
    };
    let tick_ns = match log.taken.get(&key) {
        None => return unfinished(),
        Some((_, Ending::Unused)) => return Fate::UnderWay,
        Some((_, Ending::Stale)) => return Fate::Stale,
        Some((_, Ending::Superseded)) => return Fate::Superseded,
        Some((tick_ns, Ending::Used)) => *tick_ns,
    };
    let ticks = (
        log.outer.get(&(key.0, sent.tick_ns)),
        log.outer.get(&(sent.to, tick_ns)),
    );
    let (Some(computed), Some(taken)) = ticks else {
        return Fate::Untold;
    };
    let overtaken = |newer: bool| {
        if newer {
            Fate::Overwritten
        } else {
            unfinished()
        }
    };
    let Some(&inner_ns) = log.first_inner.get(&(sent.to, tick_ns)) else {
        return overtaken(later(&log.first_inner, (sent.to, tick_ns)));
    };
    let inner = (sent.to, inner_ns);
    let Some(&applied_ns) = log.applied.get(&inner) else {
        return overtaken(later(&log.applied, inner));
    };
    let Some(obeyed) = log.inner.get(&inner) else {
        return Fate::Untold;
    };
    // What the tick had in hand was through the bus, even if its sender was suspended before it
    // could note so.
    let through_ns = sent.queued_ns.min(taken.began_ns);
    let instants_ns = [
        sent.sampled_ns,
        computed.began_ns,
        sent.sent_ns,
        through_ns,
        available_ns.max(through_ns),
        taken.began_ns,
        obeyed.began_ns,
        applied_ns,
    ];
    Fate::Used(Way { instants_ns })
}

/// Whether the robot has a later tick than this.
fn later(ticks: &BTreeMap<Tick, i64>, (robot, t_ns): Tick) -> bool {
    let range = (Excluded((robot, t_ns)), Included((robot, i64::MAX)));
    ticks.range(range).next().is_some()
}
