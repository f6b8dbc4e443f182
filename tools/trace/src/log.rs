//! The trace of a run, indexed so that a message can be followed through it.

use std::collections::{BTreeMap, BTreeSet};

use slipstream_bus::message::RobotIndex;
use slipstream_bus::record::Fate;
use slipstream_recording::Disk;

use crate::hosts::Hosts;
use crate::percentiles::Percentiles;
use crate::pile::{Groups, Keep, Pile};
use crate::step::{Loop, Step, Topic};

/// What can become of a message at its receiver, by its number in a record.
const FATES: [Fate; 4] = [Fate::Unused, Fate::Stale, Fate::Superseded, Fate::Used];

/// A message on a link: its sender, its receiver and its sequence number.
pub(crate) type Key = (RobotIndex, RobotIndex, u32);
/// A tick: the robot and when it was due (ns).
pub(crate) type Tick = (RobotIndex, i64);
/// A loop: its robot (`None`: the plant) and which.
pub(crate) type LoopKey = (Option<RobotIndex>, Loop);

/// The trace of a run: messages, ticks, deadlines, hosts, and all other spans and events.
///
/// Its memory does not grow with the number of messages and ticks: they lie in a temporary file, in the
/// order of their keys.
#[derive(Debug, Clone)]
pub struct Log {
    disk: Disk,
    /// Link, sequence number; sampled, tick due, sent, queued (ns).
    sent: Pile<6>,
    /// Link, sequence number; 1 and when the delay line releases the message (ns), or 0
    /// and 0 if it was lost.
    arrived: Pile<4>,
    /// Link, sequence number; when the message from another host came out of the network (ns).
    crossed: Pile<3>,
    /// Link, sequence number; when the receiver's outer tick was due (ns), and what became of the
    /// message there.
    taken: Pile<4>,
    /// Robot, due; began, done (ns), message or -1.
    outer: Pile<5>,
    /// Robot, due; began, done (ns).
    inner: Pile<4>,
    /// Robot, due time of the inner tick that requested the torque; when the plant applied it (ns).
    applied: Pile<3>,
    /// Robot, due time of an outer tick; when the first inner tick that follows its set-points was due
    /// (ns).
    first_inner: Pile<3>,
    /// How long what real robots tell was under way.
    heard: Groups<(RobotIndex, Topic)>,
    /// When agents died (ns).
    pub(crate) deaths: Vec<Tick>,
    /// The plant's steps on the wall clock: 0, index; due, begun and ended (ns).
    steps: Pile<5>,
    step_count: i64,
    /// Number of missed deadlines of each loop.
    pub(crate) missed: BTreeMap<LoopKey, u64>,
    /// Where the agents run, and what is known of the clocks there.
    pub(crate) hosts: Hosts,
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

impl Default for Log {
    fn default() -> Self {
        let disk = Disk::default();
        Self {
            sent: Pile::new(&disk, Keep::Last),
            arrived: Pile::new(&disk, Keep::Last),
            crossed: Pile::new(&disk, Keep::Smallest),
            taken: Pile::new(&disk, Keep::Last),
            outer: Pile::new(&disk, Keep::Last),
            inner: Pile::new(&disk, Keep::Last),
            applied: Pile::new(&disk, Keep::Smallest),
            first_inner: Pile::new(&disk, Keep::Smallest),
            heard: Groups::new(&disk),
            deaths: Vec::new(),
            steps: Pile::new(&disk, Keep::Last),
            step_count: 0,
            missed: BTreeMap::new(),
            hosts: Hosts::default(),
            notes: Vec::new(),
            disk,
        }
    }
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

    /// Whether the temporary file could be written and read so far. Ask after the last use of the log:
    /// what is computed from it is otherwise incomplete.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn check(&self) -> slipstream_recording::Result<()> {
        self.disk.check()
    }

    /// Where lists that are as long as the log belong.
    pub(crate) fn disk(&self) -> &Disk {
        &self.disk
    }

    /// Adds a span or event that belongs to no message and no tick.
    pub fn note(&mut self, note: Note) {
        self.notes.push(note);
    }

    /// Adds a step.
    pub fn take(&mut self, step: Step) {
        match step {
            Step::Sent { .. }
            | Step::Arrived { .. }
            | Step::Crossed { .. }
            | Step::Taken { .. } => self.take_message(&step),
            Step::Outer {
                robot,
                due_ns,
                began_ns,
                done_ns,
                message,
            } => {
                let message = message.map_or(-1, i64::from);
                self.outer
                    .push([robot.into(), due_ns, began_ns, done_ns, message]);
            }
            Step::Inner {
                robot,
                due_ns,
                began_ns,
                done_ns,
                outer_ns,
            } => {
                self.inner.push([robot.into(), due_ns, began_ns, done_ns]);
                self.first_inner.push([robot.into(), outer_ns, due_ns]);
            }
            Step::Applied {
                robot,
                tick_ns,
                taken_ns,
            } => self.applied.push([robot.into(), tick_ns, taken_ns]),
            Step::Heard {
                robot,
                of,
                measured_ns,
                arrived_ns,
            } => {
                let age_ns = arrived_ns.saturating_sub(measured_ns);
                self.heard.push((robot, of), age_ns);
            }
            Step::Died { robot, t_ns } => self.deaths.push((robot, t_ns)),
            Step::Deadline {
                robot,
                of,
                due_ns,
                began_ns,
                done_ns,
                missed,
            } => self.take_deadline((robot, of), [due_ns, began_ns, done_ns], missed),
            Step::Host { robot, host } => self.hosts.place(robot, host),
            Step::Clock { host, clock } => self.hosts.add(host, &clock),
        }
    }

    /// Adds a step of a message on its link.
    fn take_message(&mut self, step: &Step) {
        match *step {
            Step::Sent {
                from,
                to,
                seq,
                sampled_ns,
                tick_ns,
                sent_ns,
                queued_ns,
            } => {
                let [link, seq] = pile_key((from, to, seq));
                self.sent
                    .push([link, seq, sampled_ns, tick_ns, sent_ns, queued_ns]);
            }
            Step::Arrived {
                from,
                to,
                seq,
                available_ns,
            } => {
                let [link, seq] = pile_key((from, to, seq));
                let [is_released, t_ns] = available_ns.map_or([0, 0], |t_ns| [1, t_ns]);
                self.arrived.push([link, seq, is_released, t_ns]);
            }
            Step::Crossed {
                from,
                to,
                seq,
                t_ns,
            } => {
                let [link, seq] = pile_key((from, to, seq));
                self.crossed.push([link, seq, t_ns]);
            }
            Step::Taken {
                from,
                to,
                seq,
                tick_ns,
                fate,
            } => {
                let fate = FATES.iter().position(|known| *known == fate);
                let fate = fate.unwrap_or_default() as i64;
                let [link, seq] = pile_key((from, to, seq));
                self.taken.push([link, seq, tick_ns, fate]);
            }
            _ => {}
        }
    }

    fn take_deadline(&mut self, key: LoopKey, times_ns: [i64; 3], missed: bool) {
        *self.missed.entry(key).or_default() += u64::from(missed);
        if key == (None, Loop::Step) {
            let [due_ns, began_ns, done_ns] = times_ns;
            self.steps
                .push([0, self.step_count, due_ns, began_ns, done_ns]);
            self.step_count += 1;
        }
    }

    /// Whether there are neither messages nor ticks.
    pub(crate) fn is_empty(&self) -> bool {
        self.sent.is_empty() && self.inner.is_empty()
    }

    /// The message with this key, as it was sent.
    pub(crate) fn sent(&self, key: Key) -> Option<Sent> {
        let [_, _, sampled_ns, tick_ns, sent_ns, queued_ns] = self.sent.get(pile_key(key))?;
        Some(Sent {
            to: key.1,
            sampled_ns,
            tick_ns,
            sent_ns,
            queued_ns,
        })
    }

    /// Of a message that arrived: when the delay line releases it (ns); `None`: lost.
    pub(crate) fn arrived(&self, key: Key) -> Option<Option<i64>> {
        let [.., is_released, t_ns] = self.arrived.get(pile_key(key))?;
        Some((is_released == 1).then_some(t_ns))
    }

    /// When a message from another host came out of the network on the receiver's host (ns).
    pub(crate) fn crossed(&self, key: Key) -> Option<i64> {
        let [.., t_ns] = self.crossed.get(pile_key(key))?;
        Some(t_ns)
    }

    /// Whether a later message of the link arrived.
    pub(crate) fn arrived_after(&self, key: Key) -> bool {
        let key = pile_key(key);
        let later = self.arrived.after(key);
        later.is_some_and(|[of, ..]| of == key[0])
    }

    /// When the receiver's outer tick was due (ns), and what became of the message there.
    pub(crate) fn taken(&self, key: Key) -> Option<(i64, Fate)> {
        let [.., tick_ns, fate] = self.taken.get(pile_key(key))?;
        Some((tick_ns, *FATES.get(fate as usize)?))
    }

    /// An outer tick.
    pub(crate) fn outer(&self, (robot, due_ns): Tick) -> Option<Outer> {
        self.outer
            .get([robot.into(), due_ns])
            .map(|record| outer_of(record).1)
    }

    /// An inner tick.
    pub(crate) fn inner(&self, (robot, due_ns): Tick) -> Option<Inner> {
        self.inner
            .get([robot.into(), due_ns])
            .map(|record| inner_of(record).1)
    }

    /// When the plant applied the torque of an inner tick (ns), and whether it applied one of a later
    /// tick.
    pub(crate) fn applied(&self, tick: Tick) -> Result<i64, Later> {
        time_or_later(&self.applied, tick)
    }

    /// When the first inner tick that follows an outer tick's set-points was due (ns), and whether one
    /// follows a later tick.
    pub(crate) fn first_inner(&self, tick: Tick) -> Result<i64, Later> {
        time_or_later(&self.first_inner, tick)
    }

    /// The messages that were sent or arrived, in the order of their keys.
    pub(crate) fn messages(&self) -> impl Iterator<Item = Key> {
        let sent = self.sent.iter().map(|[link, seq, ..]| [link, seq]);
        let arrived = self.arrived.iter().map(|[link, seq, ..]| [link, seq]);
        let (mut sent, mut arrived) = (sent.peekable(), arrived.peekable());
        std::iter::from_fn(move || {
            let next = match (sent.peek(), arrived.peek()) {
                (Some(a), Some(b)) => *a.min(b),
                (Some(key), None) | (None, Some(key)) => *key,
                (None, None) => return None,
            };
            sent.next_if_eq(&next);
            arrived.next_if_eq(&next);
            Some(key_of(next))
        })
    }

    /// All outer ticks, ordered by robot and due time.
    pub(crate) fn outer_ticks(&self) -> impl Iterator<Item = (Tick, Outer)> {
        self.outer.iter().map(outer_of)
    }

    /// All inner ticks, ordered by robot and due time.
    pub(crate) fn inner_ticks(&self) -> impl Iterator<Item = (Tick, Inner)> {
        self.inner.iter().map(inner_of)
    }

    /// All torques: the inner tick that requested it, and when the plant applied it (ns).
    pub(crate) fn torques(&self) -> impl Iterator<Item = (Tick, i64)> {
        let torque = |[robot, due_ns, taken_ns]: [i64; 3]| ((index(robot), due_ns), taken_ns);
        self.applied.iter().map(torque)
    }

    /// How long what real robots tell was under way: number of messages, and percentiles.
    pub(crate) fn heard(&self) -> BTreeMap<(RobotIndex, Topic), (u64, Percentiles)> {
        self.heard.percentiles()
    }

    /// The plant's steps on the wall clock, in the order of the recording: due, begun, ended (ns).
    pub(crate) fn steps(&self) -> impl Iterator<Item = [i64; 3]> {
        self.steps
            .iter()
            .map(|[.., due_ns, began_ns, done_ns]| [due_ns, began_ns, done_ns])
    }

    /// Of each robot the one that it follows: the one ahead if it hears that one, or else the only one that it hears.
    pub(crate) fn ahead(&self) -> BTreeMap<RobotIndex, RobotIndex> {
        let mut heard: BTreeMap<RobotIndex, BTreeSet<RobotIndex>> = BTreeMap::new();
        let arrived = self.arrived.iter().map(|[link, seq, ..]| [link, seq]);
        let sent = self.sent.iter().map(|[link, seq, ..]| [link, seq]);
        for (from, to, _) in arrived.chain(sent).map(key_of) {
            heard.entry(to).or_default().insert(from);
        }
        let followed = |(to, from): (RobotIndex, BTreeSet<RobotIndex>)| {
            let ahead = to.checked_sub(1).filter(|ahead| from.contains(ahead));
            let only = from.first().copied().filter(|_| from.len() == 1);
            Some((to, ahead.or(only)?))
        };
        heard.into_iter().filter_map(followed).collect()
    }
}

/// A tick has no time; the value tells whether the robot has one for a later tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Later(pub(crate) bool);

fn time_or_later(times: &Pile<3>, (robot, t_ns): Tick) -> Result<i64, Later> {
    let key = [robot.into(), t_ns];
    match times.get(key) {
        Some([.., time_ns]) => Ok(time_ns),
        None => {
            let later = times.after(key);
            Err(Later(later.is_some_and(|[of, ..]| of == i64::from(robot))))
        }
    }
}

/// A number of a record that was an index or a sequence number.
fn index(number: i64) -> u32 {
    u32::try_from(number).unwrap_or_default()
}

/// The first two numbers of a record of a message: its link as one number, and its sequence number.
fn pile_key((from, to, seq): Key) -> [i64; 2] {
    let link = u64::from(from) << 32 | u64::from(to);
    [link.cast_signed(), seq.into()]
}

/// The message with these numbers.
fn key_of([link, seq]: [i64; 2]) -> Key {
    let link = link.cast_unsigned();
    let robot = |bits: u64| u32::try_from(bits & u64::from(u32::MAX)).unwrap_or_default();
    (robot(link >> 32), robot(link), index(seq))
}

fn outer_of([robot, due_ns, began_ns, done_ns, message]: [i64; 5]) -> (Tick, Outer) {
    let tick = Outer {
        began_ns,
        done_ns,
        message: u32::try_from(message).ok(),
    };
    ((index(robot), due_ns), tick)
}

fn inner_of([robot, due_ns, began_ns, done_ns]: [i64; 4]) -> (Tick, Inner) {
    ((index(robot), due_ns), Inner { began_ns, done_ns })
}
