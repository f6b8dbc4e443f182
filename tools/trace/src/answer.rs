//! The answer of `slipstream trace`; its JSON Schema is in `tools/cli/schemas`.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use slipstream_bus::time::s_from_ns;

use crate::chain::{Chain, Fate, Link, Message, STAGES, by_link, follow};
use crate::compare::HopChange;
use crate::log::{Log, LoopKey};
use crate::names::Names;
use crate::percentiles::Percentiles;
use crate::step::Loop;

/// The whole answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
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
pub fn answer(log: &Log, names: &[String]) -> Answer {
    let names = Names(names);
    let messages = follow(log);
    Answer {
        format: 1,
        hops: hops(&messages, &names),
        platoon: platoon(log, &messages, &names),
        at_outer_ticks: at_outer_ticks(log, &names),
        loops: loops(log, &names),
        against: None,
    }
}

fn hops(messages: &[Message], names: &Names<'_>) -> Vec<Hop> {
    let links = by_link(messages.iter().map(|message| (message.link(), message)));
    links
        .into_iter()
        .map(|((from, to), messages)| hop(names.of(from), names.of(to), &messages))
        .collect()
}

fn hop(from: String, to: String, messages: &[&Message]) -> Hop {
    let mut incomplete = Incomplete::default();
    let mut chains: Vec<Chain> = Vec::new();
    for message in messages {
        match message.fate {
            Fate::Used(chain) => chains.push(chain),
            Fate::Lost => incomplete.lost += 1,
            Fate::Superseded => incomplete.superseded += 1,
            Fate::Stale => incomplete.stale += 1,
            Fate::Overwritten => incomplete.overwritten += 1,
            Fate::UnderWay => incomplete.under_way += 1,
            Fate::Died => incomplete.receiver_died += 1,
            Fate::Untold => incomplete.untold += 1,
        }
    }
    let stage = |(i, &stage): (usize, &'static &'static str)| {
        let durations = chains.iter().map(|chain| chain.stages_ns()[i]).collect();
        Percentiles::new(durations).map(|figures| StageLatency {
            stage: stage.into(),
            figures,
        })
    };
    let sum = |chain: &Chain| chain.stages_ns().into_iter().fold(0, i64::saturating_add);
    let error = |chain: &Chain| {
        chain
            .end_to_end_ns()
            .saturating_sub(sum(chain))
            .saturating_abs()
    };
    let largest = chains.iter().map(error).max();
    Hop {
        from,
        to,
        messages: chains.len() as u64,
        sent: messages.len() as u64,
        incomplete,
        stages: STAGES.iter().enumerate().filter_map(stage).collect(),
        end_to_end: Percentiles::new(chains.iter().map(Chain::end_to_end_ns).collect()),
        largest_sum_error_s: s_from_ns(largest.unwrap_or(0)),
    }
}

/// Percentiles of the ages of each pair, ordered by `from`, then `to`.
fn ages(pairs: BTreeMap<Link, Vec<i64>>, names: &Names<'_>) -> Vec<Age> {
    let age = |((from, to), ages): (Link, Vec<i64>)| {
        let count = ages.len() as u64;
        Percentiles::new(ages).map(|figures| Age {
            from: names.of(from),
            to: names.of(to),
            count,
            figures,
        })
    };
    pairs.into_iter().filter_map(age).collect()
}

/// Follows each used message back along the platoon: to the message that its sender used, and so on.
fn platoon(log: &Log, messages: &[Message], names: &Names<'_>) -> Vec<Age> {
    let ahead = log.sender_to();
    let mut pairs: BTreeMap<Link, Vec<i64>> = BTreeMap::new();
    for message in messages {
        // The front robot follows nobody: in a ring, the returning message only triggers its next one.
        let Fate::Used(chain) = message.fate else {
            continue;
        };
        if message.to == 0 {
            continue;
        }
        let applied_ns = chain.instants_ns[7];
        let mut key = (message.from, message.seq);
        for _ in 0..=ahead.len() {
            let Some(sent) = log.sent.get(&key) else {
                break;
            };
            let age_ns = applied_ns.saturating_sub(sent.sampled_ns);
            pairs.entry((key.0, message.to)).or_default().push(age_ns);
            let tick = log.outer.get(&(key.0, sent.tick_ns));
            let before = tick.and_then(|tick| tick.message).zip(ahead.get(&key.0));
            match before {
                Some((seq, &from)) if key.0 != 0 => key = (from, seq),
                _ => break,
            }
        }
    }
    ages(pairs, names)
}

fn at_outer_ticks(log: &Log, names: &Names<'_>) -> Vec<Age> {
    let ahead = log.sender_to();
    let mut pairs: BTreeMap<Link, Vec<i64>> = BTreeMap::new();
    for (&(robot, _), tick) in &log.outer {
        let key = ahead.get(&robot).copied().zip(tick.message);
        if let Some((key, sent)) = key.and_then(|key| Some((key, log.sent.get(&key)?))) {
            let age_ns = tick.began_ns.saturating_sub(sent.sampled_ns);
            pairs.entry((key.0, robot)).or_default().push(age_ns);
        }
    }
    ages(pairs, names)
}

fn loops(log: &Log, names: &Names<'_>) -> Vec<LoopTiming> {
    let mut ticks: BTreeMap<LoopKey, Vec<[i64; 2]>> = BTreeMap::new();
    for (&(robot, t_ns), tick) in &log.inner {
        let times = ticks.entry((Some(robot), Loop::Inner)).or_default();
        times.push([t_ns, tick.began_ns]);
    }
    for (&(robot, t_ns), tick) in &log.outer {
        let times = ticks.entry((Some(robot), Loop::Outer)).or_default();
        times.push([t_ns, tick.began_ns]);
    }
    let plant = (None, Loop::Step);
    if let Some(times) = log.deadlines.get(&plant) {
        let times = times
            .iter()
            .map(|&[due_ns, began_ns, _]| [due_ns, began_ns]);
        ticks.insert(plant, times.collect());
    }
    let figures = |(of, times): (LoopKey, Vec<[i64; 2]>)| {
        let late = |&[due, began]: &[i64; 2]| began.saturating_sub(due);
        let lateness: Vec<i64> = times.iter().map(late).collect();
        let change = |pair: &[i64]| pair[1].saturating_sub(pair[0]).saturating_abs();
        let jitter = lateness.windows(2).map(change).collect();
        Percentiles::new(lateness).map(|late| LoopTiming {
            process: of
                .0
                .map_or_else(|| "plant".to_owned(), |robot| names.of(robot)),
            name: of.1.name().into(),
            ticks: times.len() as u64,
            left_out: left_out(&times),
            missed: log.missed.get(&of).copied().unwrap_or(0),
            late,
            jitter: Percentiles::new(jitter),
        })
    };
    ticks.into_iter().filter_map(figures).collect()
}

/// Ticks missing between these; all are due at whole multiples of one period.
fn left_out(times: &[[i64; 2]]) -> u64 {
    let gaps = || {
        times
            .windows(2)
            .map(|pair| pair[1][0].saturating_sub(pair[0][0]))
    };
    let Some(period_ns) = gaps().min().filter(|&period_ns| period_ns > 0) else {
        return 0;
    };
    gaps().map(|gap| (gap / period_ns - 1).unsigned_abs()).sum()
}
