//! What a run told, sorted so that a message can be followed through it.

use std::collections::BTreeMap;

use slipstream_bus::message::{Position, RobotIndex};
use slipstream_bus::record::{EventKind, Fate, Record, Recorder};

/// A message: its sender and the sender's count.
pub(crate) type Key = (RobotIndex, u32);
/// A tick: the robot and when it was due (ns).
pub(crate) type Tick = (RobotIndex, i64);

/// Everything that the records of a run say about messages and ticks.
#[derive(Debug, Clone, Default)]
pub struct Log {
    pub(crate) sent: BTreeMap<Key, Sent>,
    /// The receiver, and when the delay line gives it out (ns); `None`: lost.
    pub(crate) arrived: BTreeMap<Key, (RobotIndex, Option<i64>)>,
    /// The receiver's outer tick (ns), and what became of the message there.
    pub(crate) taken: BTreeMap<Key, (i64, Fate)>,
    pub(crate) outer: BTreeMap<Tick, Outer>,
    pub(crate) inner: BTreeMap<Tick, Inner>,
    /// By the inner tick that asked for it: when the plant took the torque up (ns).
    pub(crate) applied: BTreeMap<Tick, i64>,
    /// The first inner tick that obeys an outer tick, by the outer tick (ns).
    pub(crate) first_inner: BTreeMap<Tick, i64>,
    /// When agents died (ns).
    pub(crate) deaths: Vec<Tick>,
}

/// A sending.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sent {
    pub(crate) to: RobotIndex,
    pub(crate) position: Position,
    pub(crate) queued_ns: i64,
}

/// An outer tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Outer {
    pub(crate) began_ns: i64,
    /// The number of the message from the robot ahead that it goes by.
    pub(crate) message: Option<u32>,
}

/// An inner tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Inner {
    pub(crate) began_ns: i64,
}

impl Log {
    /// The log of these records, in any order.
    pub fn new<'a>(records: impl IntoIterator<Item = &'a Record>) -> Self {
        let mut log = Self::default();
        for record in records {
            log.record(record);
        }
        log
    }

    /// Whom robot `to` hears: the sender of the messages that came to it.
    pub(crate) fn sender_to(&self) -> BTreeMap<RobotIndex, RobotIndex> {
        let heard = self.arrived.iter().map(|(key, (to, _))| (*to, key.0));
        let sent = self.sent.iter().map(|(key, sent)| (sent.to, key.0));
        heard.chain(sent).collect()
    }
}

impl Recorder for Log {
    fn record(&mut self, record: &Record) {
        match *record {
            Record::Sent {
                to,
                position,
                queued_ns,
            } => {
                let sent = Sent {
                    to,
                    position,
                    queued_ns,
                };
                self.sent.insert((position.from, position.seq), sent);
            }
            Record::Arrived {
                from,
                to,
                seq,
                available_ns,
                ..
            } => {
                self.arrived.insert((from, seq), (to, available_ns));
            }
            Record::Taken {
                from,
                seq,
                tick_ns,
                fate,
                ..
            } => {
                self.taken.insert((from, seq), (tick_ns, fate));
            }
            Record::Outer(tick) => {
                let outer = Outer {
                    began_ns: tick.began_ns,
                    message: tick.message,
                };
                self.outer.insert((tick.robot, tick.t_ns), outer);
            }
            Record::Inner(tick) => {
                let began_ns = tick.began_ns;
                self.inner
                    .insert((tick.robot, tick.t_ns), Inner { began_ns });
                let first = self.first_inner.entry((tick.robot, tick.outer_ns));
                let first = first.or_insert(tick.t_ns);
                *first = tick.t_ns.min(*first);
            }
            Record::Applied {
                robot,
                tick_ns,
                taken_ns,
                ..
            } => {
                let first = self.applied.entry((robot, tick_ns)).or_insert(taken_ns);
                *first = taken_ns.min(*first);
            }
            Record::Event {
                t_ns,
                robot: Some(robot),
                kind: EventKind::Died,
            } => self.deaths.push((robot, t_ns)),
            Record::Event { .. }
            | Record::State(_)
            | Record::Encoders { .. }
            | Record::Camera { .. }
            | Record::Imu { .. } => {}
        }
    }
}
