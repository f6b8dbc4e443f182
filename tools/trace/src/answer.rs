//! The answer of `slipstream trace`; its JSON Schema is in `tools/cli/schemas`.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use slipstream_bus::message::RobotIndex;
use slipstream_bus::time::s_from_ns;

use crate::chain::{Fate, Link, STAGES, messages};
use crate::compare::HopChange;
use crate::hosts::HostClock;
use crate::log::{Inner, Log, LoopKey, Outer, Tick};
use crate::names::Names;
use crate::percentiles::Percentiles;
use crate::pile::Groups;
use crate::step::{Loop, Topic};
use crate::uncertain_groups::{UncertainGroups, UncertainPercentiles};
use crate::uncertainty::Uncertainty;

/// The whole answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LatencyAnswer {
    /// Version of this format.
    pub format: u32,
    /// Every link that a message was sent on.
    pub hops: Vec<Hop>,
    /// For each pair of robots: age of the follower's information about a robot ahead when a torque
    /// results from it.
    pub platoon: Vec<Age>,
    /// Age of the information about the robot ahead at each outer tick that uses it.
    pub at_outer_ticks: Vec<Age>,
    /// Timing of the control loops, the plant's first.
    pub loops: Vec<LoopTiming>,
    /// Hosts other than that of the plant, and their clocks; empty for a run on one host.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hosts: Vec<Host>,
    /// Topics of real robots; empty for a simulated run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub topics: Vec<TopicDelay>,
    /// Difference of each link from another run, if one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<Vec<HopChange>>,
}

/// One link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hop {
    /// The sender.
    pub from: String,
    /// The receiver.
    pub to: String,
    /// Messages that were used, so that a torque results from them. The latencies are theirs.
    pub messages: u64,
    /// Messages that were sent.
    pub sent: u64,
    /// What became of the other messages.
    pub incomplete: Incomplete,
    /// The stages in the order of the chain.
    pub stages: Vec<StageLatency>,
    /// From the encoder sample to the torque; null if no message was used.
    pub end_to_end: Option<Percentiles>,
    /// The largest difference between a message's end-to-end latency and the sum of its stages (s).
    pub largest_sum_error_s: f64,
}

/// Messages without a complete chain, counted by what became of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Incomplete {
    /// Lost on the link.
    pub lost: u64,
    /// A newer message left the delay line at the same tick.
    pub superseded: u64,
    /// A newer message had arrived before.
    pub stale: u64,
    /// Used by an outer tick, whose set-points a newer tick replaced before any torque.
    pub overwritten: u64,
    /// The recording ends before the chain is complete.
    pub under_way: u64,
    /// The receiver's process died before it used them.
    pub receiver_died: u64,
    /// Records of their chain are missing.
    pub untold: u64,
}

/// One stage of a link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageLatency {
    /// Its name.
    pub stage: Cow<'static, str>,
    /// How long it took.
    #[serde(flatten)]
    pub figures: Percentiles,
    /// By how much the median can be wrong, because the stage begins and ends on the clocks of two hosts.
    #[serde(default, skip_serializing_if = "Uncertainty::is_exact")]
    pub uncertainty_s: Uncertainty,
}

/// Age of one robot's information about another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Age {
    /// The robot that the information is about.
    pub from: String,
    /// The robot that uses it.
    pub to: String,
    /// Number of samples.
    pub count: u64,
    /// Time since the encoders were read.
    #[serde(flatten)]
    pub figures: Percentiles,
    /// By how much the median can be wrong, because the encoders are read on the clock of the plant's host
    /// and used on that of another.
    #[serde(default, skip_serializing_if = "Uncertainty::is_exact")]
    pub uncertainty_s: Uncertainty,
}

/// A host other than that of the plant, and its monotonic clock beside that of the plant's host. A figure
/// is `None` if the recording does not tell it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Host {
    /// Its name.
    pub host: String,
    /// The robots whose agents run there.
    pub robots: Vec<String>,
    /// Number of estimates of its clock.
    pub windows: u64,
    /// Its clock minus that of the plant's host (s): the last estimate.
    pub offset_s: Option<f64>,
    /// How much faster its clock runs (10⁻⁶): the last estimate.
    pub drift_ppm: Option<f64>,
    /// Largest bound of an estimate of the offset (s).
    pub bound_s: Option<f64>,
    /// Largest error of its time stamps from time 0 on (s): the bound plus the correction that the clock of
    /// the run there has not made yet.
    pub error_s: Option<f64>,
    /// Smallest round trip to it (s).
    pub round_trip_s: Option<f64>,
}

/// How long messages on a topic of a real robot were under way. Of what the robot tells: from its stamp until it came out
/// of the network, beyond the fastest message, whose own delay nobody knows. Of commands: from the end of the agent's
/// inner tick until the message was published.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TopicDelay {
    /// The robot.
    pub robot: String,
    /// `wheels`, `pose`, `odometry`, `imu` or `command`.
    pub topic: Cow<'static, str>,
    /// Number of messages.
    pub messages: u64,
    /// The delay.
    #[serde(flatten)]
    pub figures: Percentiles,
}

/// Timing of one loop. The plant's step has deadlines only on the wall clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LoopTiming {
    /// `plant`, or the robot.
    pub process: String,
    /// `step`, `outer` or `inner`.
    #[serde(rename = "loop")]
    pub name: Cow<'static, str>,
    /// Ticks that ran.
    pub ticks: u64,
    /// Ticks that were due in between and did not run.
    pub left_out: u64,
    /// Ticks that ran but ended after the next one was due.
    pub missed: u64,
    /// Lateness: how long after its due time each tick began.
    pub late: Percentiles,
    /// Jitter: absolute deviation of the time between two ticks from the nominal one.
    pub jitter: Option<Percentiles>,
}

/// Computes the answer for a run; `names` by the robots' index.
pub fn answer(log: &Log, names: &[String]) -> LatencyAnswer {
    let names = Names(names);
    LatencyAnswer {
        format: 1,
        hops: hops(log, &names),
        platoon: platoon(log, &names),
        at_outer_ticks: at_outer_ticks(log, &names),
        loops: loops(log, &names),
        hosts: hosts(log, &names),
        topics: topics(log, &names),
        against: None,
    }
}

/// The messages of a link, counted.
#[derive(Debug, Default)]
struct MessageCount {
    sent: u64,
    used: u64,
    incomplete: Incomplete,
    largest_sum_error_ns: i64,
}

impl MessageCount {
    fn add(&mut self, fate: &Fate) {
        self.sent += 1;
        let incomplete = &mut self.incomplete;
        match fate {
            Fate::Used(chain) => {
                self.used += 1;
                let sum = chain.stages_ns().into_iter().fold(0, i64::saturating_add);
                let error = chain.end_to_end_ns().saturating_sub(sum).saturating_abs();
                self.largest_sum_error_ns = self.largest_sum_error_ns.max(error);
            }
            Fate::Lost => incomplete.lost += 1,
            Fate::Superseded => incomplete.superseded += 1,
            Fate::Stale => incomplete.stale += 1,
            Fate::Overwritten => incomplete.overwritten += 1,
            Fate::UnderWay => incomplete.under_way += 1,
            Fate::Died => incomplete.receiver_died += 1,
            Fate::Untold => incomplete.untold += 1,
        }
    }
}

fn hops(log: &Log, names: &Names<'_>) -> Vec<Hop> {
    let mut counts: BTreeMap<Link, MessageCount> = BTreeMap::new();
    let mut stages = STAGES.map(|_| UncertainGroups::new(log.disk()));
    let mut end_to_end = Groups::new(log.disk());
    for message in messages(log) {
        let link = message.link();
        counts.entry(link).or_default().add(&message.fate);
        if let Fate::Used(chain) = message.fate {
            let durations = chain.stages_ns().into_iter().zip(chain.uncertainty);
            for (stage, (duration_ns, uncertainty)) in stages.iter_mut().zip(durations) {
                stage.push(link, duration_ns, uncertainty);
            }
            end_to_end.push(link, chain.end_to_end_ns());
        }
    }
    let (stages, end_to_end) = (stages.map(|s| s.percentiles()), end_to_end.percentiles());
    let hop = |(link, count): (Link, MessageCount)| {
        let stage = |(&stage, of): (&&'static str, &UncertainPercentiles<Link>)| {
            let (_, figures, uncertainty_s) = *of.get(&link)?;
            Some(StageLatency {
                stage: stage.into(),
                figures,
                uncertainty_s,
            })
        };
        Hop {
            from: names.of(link.0),
            to: names.of(link.1),
            messages: count.used,
            sent: count.sent,
            incomplete: count.incomplete,
            stages: STAGES.iter().zip(&stages).filter_map(stage).collect(),
            end_to_end: end_to_end.get(&link).map(|(_, figures)| *figures),
            largest_sum_error_s: s_from_ns(count.largest_sum_error_ns),
        }
    };
    counts.into_iter().map(hop).collect()
}

/// Percentiles of the ages of each pair, ordered by `from`, then `to`.
fn ages(pairs: &UncertainGroups<Link>, names: &Names<'_>) -> Vec<Age> {
    let age = |((from, to), (count, figures, uncertainty_s))| Age {
        from: names.of(from),
        to: names.of(to),
        count,
        figures,
        uncertainty_s,
    };
    pairs.percentiles().into_iter().map(age).collect()
}

/// Follows each used message back along the platoon: to the message that its sender used, and so on.
fn platoon(log: &Log, names: &Names<'_>) -> Vec<Age> {
    let ahead = log.ahead();
    let mut pairs = UncertainGroups::new(log.disk());
    for message in messages(log) {
        // The front robot follows nobody: in a ring, the returning message only triggers its next one.
        let Fate::Used(chain) = message.fate else {
            continue;
        };
        if message.to == 0 {
            continue;
        }
        let applied_ns = chain.instants_ns[7];
        let mut key = (message.from, message.to, message.seq);
        for _ in 0..=ahead.len() {
            let Some(sent) = log.sent(key) else {
                break;
            };
            // Both are on the clock of the plant's host.
            let age_ns = applied_ns.saturating_sub(sent.sampled_ns);
            pairs.push((key.0, message.to), age_ns, Uncertainty::Exact);
            let tick = log.outer((key.0, sent.tick_ns));
            let before = tick.and_then(|tick| tick.message).zip(ahead.get(&key.0));
            match before {
                Some((seq, &from)) if key.0 != 0 => key = (from, key.0, seq),
                _ => break,
            }
        }
    }
    ages(&pairs, names)
}

fn at_outer_ticks(log: &Log, names: &Names<'_>) -> Vec<Age> {
    let mut pairs = UncertainGroups::new(log.disk());
    for (link, began_ns, age_ns) in used_at_outer_ticks(log) {
        pairs.push(link, age_ns, log.hosts.error(link.1, began_ns));
    }
    ages(&pairs, names)
}

/// Each outer tick that uses a position: the link, when it began (ns), and how old the position is (ns).
fn used_at_outer_ticks(log: &Log) -> impl Iterator<Item = (Link, i64, i64)> {
    let ahead = log.ahead();
    log.outer_ticks().filter_map(move |((robot, _), tick)| {
        let (from, seq) = ahead.get(&robot).copied().zip(tick.message)?;
        let sent = log.sent((from, robot, seq))?;
        let age_ns = tick.began_ns.saturating_sub(sent.sampled_ns);
        Some(((from, robot), tick.began_ns, age_ns))
    })
}

/// Age of the position that a robot uses, over time.
#[derive(Debug, Clone, PartialEq)]
pub struct AgeLine {
    /// The robot ahead.
    pub from: RobotIndex,
    /// The robot that uses its position.
    pub to: RobotIndex,
    /// Time of the outer tick and age (s), in order; thinned to some thousands.
    pub points: Vec<(f64, f64)>,
}

/// Most points of an age over time.
const AGE_POINTS: usize = 4000;

/// Age of the position in use at the outer ticks of each robot.
pub fn ages_over_time(log: &Log) -> Vec<AgeLine> {
    let mut counts: BTreeMap<Link, usize> = BTreeMap::new();
    for (link, ..) in used_at_outer_ticks(log) {
        *counts.entry(link).or_default() += 1;
    }
    let mut lines: BTreeMap<Link, (usize, Vec<(f64, f64)>)> = BTreeMap::new();
    for (link, began_ns, age_ns) in used_at_outer_ticks(log) {
        let stride = counts
            .get(&link)
            .map_or(1, |count| count.div_ceil(AGE_POINTS).max(1));
        let (seen, points) = lines.entry(link).or_default();
        if *seen % stride == 0 {
            points.push((s_from_ns(began_ns), s_from_ns(age_ns)));
        }
        *seen += 1;
    }
    let line = |((from, to), (_, points))| AgeLine { from, to, points };
    lines.into_iter().map(line).collect()
}

fn loops(log: &Log, names: &Names<'_>) -> Vec<LoopTiming> {
    let inner = |((robot, due_ns), tick): (Tick, Inner)| {
        ((Some(robot), Loop::Inner), [due_ns, tick.began_ns])
    };
    let outer = |((robot, due_ns), tick): (Tick, Outer)| {
        ((Some(robot), Loop::Outer), [due_ns, tick.began_ns])
    };
    let step = |[due_ns, began_ns, _]: [i64; 3]| ((None, Loop::Step), [due_ns, began_ns]);
    let ticks = || {
        let inner = log.inner_ticks().map(inner);
        inner
            .chain(log.outer_ticks().map(outer))
            .chain(log.steps().map(step))
    };
    let (mut late, mut jitter) = (Groups::new(log.disk()), Groups::new(log.disk()));
    let mut periods: BTreeMap<LoopKey, i64> = BTreeMap::new();
    let mut before = None;
    for (of, [due_ns, began_ns]) in ticks() {
        let late_ns = began_ns.saturating_sub(due_ns);
        late.push(of, late_ns);
        if let Some((last_due_ns, last_late_ns)) = last_of(&mut before, of, (due_ns, late_ns)) {
            jitter.push(of, late_ns.saturating_sub(last_late_ns).saturating_abs());
            let gap_ns = due_ns.saturating_sub(last_due_ns);
            let period_ns = periods.entry(of).or_insert(gap_ns);
            *period_ns = gap_ns.min(*period_ns);
        }
    }
    let left_out = left_out(ticks().map(|(of, [due_ns, _])| (of, due_ns)), &periods);
    let jitter = jitter.percentiles();
    let figures = |(of, (ticks, late)): (LoopKey, (u64, Percentiles))| LoopTiming {
        process: of
            .0
            .map_or_else(|| "plant".to_owned(), |robot| names.of(robot)),
        name: of.1.name().into(),
        ticks,
        left_out: left_out.get(&of).copied().unwrap_or(0),
        missed: log.missed.get(&of).copied().unwrap_or(0),
        late,
        jitter: jitter.get(&of).map(|(_, figures)| *figures),
    };
    late.percentiles().into_iter().map(figures).collect()
}

fn hosts(log: &Log, names: &Names<'_>) -> Vec<Host> {
    let host = |(host, clock): (&str, &HostClock)| Host {
        host: host.to_owned(),
        robots: log.hosts.robots_on(host).map(|r| names.of(r)).collect(),
        windows: clock.windows,
        offset_s: clock.last.map(|last| s_from_ns(last.offset_ns)),
        drift_ppm: clock.drift_ppb().map(|drift_ppb| drift_ppb as f64 / 1e3),
        bound_s: clock.last.map(|_| s_from_ns(clock.bound_ns)),
        error_s: clock.largest_error_ns().map(s_from_ns),
        round_trip_s: clock.round_trip_ns.map(s_from_ns),
    };
    log.hosts.clocks().map(host).collect()
}

fn topics(log: &Log, names: &Names<'_>) -> Vec<TopicDelay> {
    let mut all = log.heard();
    if all.is_empty() {
        return Vec::new();
    }
    let mut told = Groups::new(log.disk());
    for (tick, taken_ns) in log.torques() {
        if let Some(inner) = log.inner(tick) {
            let delay_ns = taken_ns.saturating_sub(inner.done_ns);
            told.push((tick.0, Topic::Command), delay_ns);
        }
    }
    all.extend(told.percentiles());
    let delay =
        |((robot, topic), (messages, figures)): ((RobotIndex, Topic), (u64, Percentiles))| {
            TopicDelay {
                robot: names.of(robot),
                topic: topic.name().into(),
                messages,
                figures,
            }
        };
    all.into_iter().map(delay).collect()
}

/// Replaces what is known of the last tick. Returns it if it was one of the same loop.
fn last_of<T>(last: &mut Option<(LoopKey, T)>, of: LoopKey, next: T) -> Option<T> {
    let (last_of, value) = last.replace((of, next))?;
    (last_of == of).then_some(value)
}

/// Ticks missing between these of each loop, which are due at whole multiples of its period (ns).
fn left_out(
    due: impl Iterator<Item = (LoopKey, i64)>,
    periods: &BTreeMap<LoopKey, i64>,
) -> BTreeMap<LoopKey, u64> {
    let mut left_out: BTreeMap<LoopKey, u64> = BTreeMap::new();
    let mut before = None;
    for (of, due_ns) in due {
        let Some(last_ns) = last_of(&mut before, of, due_ns) else {
            continue;
        };
        if let Some(period_ns) = periods.get(&of).filter(|period_ns| **period_ns > 0) {
            let gap = due_ns.saturating_sub(last_ns);
            *left_out.entry(of).or_default() += (gap / period_ns - 1).unsigned_abs();
        }
    }
    left_out
}
