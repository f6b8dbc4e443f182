//! The trace of a run, indexed so that a message can be followed through it.

use std::collections::BTreeMap;

use slipstream_bus::message::RobotIndex;
use slipstream_bus::record::Fate;

use crate::step::{Loop, Step};

/// A message: its sender and its sequence number.
pub(crate) type Key = (RobotIndex, u32);
/// A tick: the robot and when it was due (ns).
pub(crate) type Tick = (RobotIndex, i64);
/// A loop: its robot (`None`: the plant) and which.
pub(crate) type LoopKey = (Option<RobotIndex>, Loop);

/// The trace of a run: messages, ticks, deadlines, and all other spans and events.
#[derive(Debug, Clone, Default)]
pub struct Log {
    pub(crate) sent: BTreeMap<Key, Sent>,
    /// The receiver, and when the delay line releases the message (ns); `None`: lost.
    pub(crate) arrived: BTreeMap<Key, (RobotIndex, Option<i64>)>,
    /// When the receiver's outer tick was due (ns), and what became of the message there.
    pub(crate) taken: BTreeMap<Key, (i64, Fate)>,
    pub(crate) outer: BTreeMap<Tick, Outer>,
    pub(crate) inner: BTreeMap<Tick, Inner>,
    /// By the inner tick that requested the torque: when the plant applied it (ns).
    pub(crate) applied: BTreeMap<Tick, i64>,
    /// By outer tick: when the first inner tick that follows its set-points was due (ns).
    pub(crate) first_inner: BTreeMap<Tick, i64>,
    /// When agents died (ns).
    pub(crate) deaths: Vec<Tick>,
    /// The ticks of each loop on the wall clock: due, begun and ended (ns).
    pub(crate) deadlines: BTreeMap<LoopKey, Vec<[i64; 3]>>,
    /// Number of missed deadlines of each loop.
    pub(crate) missed: BTreeMap<LoopKey, u64>,
    /// Spans and events that belong to no message and no tick.
    pub(crate) notes: Vec<Note>,
}

/// A span or event that belongs to no message and no tick.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The process that recorded it.
    pub process: String,
    /// Its name.
    pub name: String,
    /// When it began (ns).
    pub begin_ns: i64,
    /// When it closed (ns); `None` for an event.
    pub end_ns: Option<i64>,
    /// Its other fields.
    pub fields: serde_json::Map<String, serde_json::Value>,
}

/// A message as sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sent {
    pub(crate) to: RobotIndex,
    pub(crate) sampled_ns: i64,
    pub(crate) tick_ns: i64,
    pub(crate) sent_ns: i64,
    pub(crate) queued_ns: i64,
}

/// An outer tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Outer {
    pub(crate) began_ns: i64,
    pub(crate) done_ns: i64,
    /// Sequence number of the message from the robot ahead that it uses.
    pub(crate) message: Option<u32>,
}

/// An inner tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Inner {
    pub(crate) began_ns: i64,
    pub(crate) done_ns: i64,
}

/// Keeps the earliest time (ns) of each tick.
fn keep_first(times: &mut BTreeMap<Tick, i64>, tick: Tick, t_ns: i64) {
    let first = times.entry(tick).or_insert(t_ns);
    *first = t_ns.min(*first);
}

impl Log {
    /// A log of these steps, given in any order.
    pub fn new(steps: impl IntoIterator<Item = Step>) -> Self {
        let mut log = Self::default();
        for step in steps {
            log.take(step);
        }
        log
    }

    /// Adds a span or event that belongs to no message and no tick.
    pub fn note(&mut self, note: Note) {
        self.notes.push(note);
    }

    /// Adds a step.
    pub fn take(&mut self, step: Step) {
        match step {
            Step::Sent {
                from,
                to,
                seq,
                sampled_ns,
                tick_ns,
                sent_ns,
                queued_ns,
            } => {
                let sent = Sent {
                    to,
                    sampled_ns,
                    tick_ns,
                    sent_ns,
                    queued_ns,
                };
                self.sent.insert((from, seq), sent);
            }
            Step::Arrived {
                from,
                to,
                seq,
                available_ns,
            } => {
                self.arrived.insert((from, seq), (to, available_ns));
            }
            Step::Taken {
                from,
                seq,
                tick_ns,
                fate,
            } => {
                self.taken.insert((from, seq), (tick_ns, fate));
            }
            Step::Outer {
                robot,
                due_ns,
                began_ns,
                done_ns,
                message,
            } => {
                let tick = Outer {
                    began_ns,
                    done_ns,
                    message,
                };
                self.outer.insert((robot, due_ns), tick);
            }
            Step::Inner {
                robot,
                due_ns,
                began_ns,
                done_ns,
                outer_ns,
            } => {
                let tick = Inner { began_ns, done_ns };
                self.inner.insert((robot, due_ns), tick);
                keep_first(&mut self.first_inner, (robot, outer_ns), due_ns);
            }
            Step::Applied {
                robot,
                tick_ns,
                taken_ns,
            } => keep_first(&mut self.applied, (robot, tick_ns), taken_ns),
            Step::Died { robot, t_ns } => self.deaths.push((robot, t_ns)),
            Step::Deadline {
                robot,
                of,
                due_ns,
                began_ns,
                done_ns,
                missed,
            } => self.take_deadline((robot, of), [due_ns, began_ns, done_ns], missed),
        }
    }

    fn take_deadline(&mut self, key: LoopKey, times_ns: [i64; 3], missed: bool) {
        self.deadlines.entry(key).or_default().push(times_ns);
        *self.missed.entry(key).or_default() += u64::from(missed);
    }

    /// The robot that each robot receives messages from.
    pub(crate) fn sender_to(&self) -> BTreeMap<RobotIndex, RobotIndex> {
        let heard = self.arrived.iter().map(|(key, (to, _))| (*to, key.0));
        let sent = self.sent.iter().map(|(key, sent)| (sent.to, key.0));
        heard.chain(sent).collect()
    }
}
