//! What `slipstream trace` answers (CONTRACT.md, section 5), and what is added to it.

use std::collections::BTreeMap;

use serde::Serialize;
use slipstream_bus::message::RobotIndex;
use slipstream_bus::time::s_from_ns;

use crate::against::HopChange;
use crate::figures::Figures;
use crate::log::{Log, LoopOf};
use crate::step::Loop;
use crate::way::{Fate, Link, Message, STAGES, Way, by_link, follow};

/// The whole answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// The version of this form.
    pub format: u32,
    /// Each link that a message was sent on.
    pub hops: Vec<Hop>,
    /// How old the information of each robot ahead is when a torque answers it.
    pub platoon: Vec<Age>,
    /// How old the information of the robot ahead is at each outer tick that goes by it.
    pub at_outer_ticks: Vec<Age>,
    /// How punctual the loops were, the plant's first.
    pub loops: Vec<LoopFigures>,
    /// How each link differs from another run, where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<Vec<HopChange>>,
}

/// One link.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hop {
    /// The sender.
    pub from: String,
    /// The receiver.
    pub to: String,
    /// Messages that were used: a torque answers them. The figures are theirs.
    pub messages: u64,
    /// Messages that were sent.
    pub sent: u64,
    /// What became of the others.
    pub incomplete: Incomplete,
    /// The stages in the order of the way.
    pub stages: Vec<StageFigures>,
    /// From the encoder sample to the torque; null where no message was used.
    pub end_to_end: Option<Figures>,
    /// The largest difference between a message's end-to-end latency and the sum of its stages (s).
    pub largest_sum_error_s: f64,
}

/// Messages without a complete way, by what became of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Incomplete {
    /// The link lost them.
    pub lost: u64,
    /// A newer one left the delay line at the same tick.
    pub superseded: u64,
    /// A newer one had come before.
    pub stale: u64,
    /// Used by an outer tick, but a newer tick came before any torque.
    pub overwritten: u64,
    /// The recording ends before their way does.
    pub under_way: u64,
    /// The receiver's process died before it took them up.
    pub receiver_died: u64,
    /// Records of their way are missing.
    pub untold: u64,
}

/// One stage of a link.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageFigures {
    /// Its name.
    pub stage: &'static str,
    /// How long it took.
    #[serde(flatten)]
    pub figures: Figures,
}

/// How old one robot's information about another is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Age {
    /// Whom it is about.
    pub from: String,
    /// Who uses it.
    pub to: String,
    /// How often it was measured.
    pub count: u64,
    /// Since the encoders behind it were read.
    #[serde(flatten)]
    pub figures: Figures,
}

/// One loop. The plant's step keeps deadlines on the wall clock alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoopFigures {
    /// `plant`, or the robot.
    pub process: String,
    /// `step`, `outer` or `inner`.
    #[serde(rename = "loop")]
    pub name: &'static str,
    /// Ticks that ran.
    pub ticks: u64,
    /// Ticks that were due between them and did not run.
    pub left_out: u64,
    /// Ticks that ran, but were done after the next one was due.
    pub missed: u64,
    /// How long after it was due each tick ran.
    pub late: Figures,
    /// How much more or less time lay between two ticks than should have.
    pub jitter: Option<Figures>,
}

/// The answer for a run; `names` by the robots' index.
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

/// The robots' names by their index.
pub(crate) struct Names<'a>(pub(crate) &'a [String]);

impl Names<'_> {
    pub(crate) fn of(&self, robot: RobotIndex) -> String {
        let name = self.0.get(robot as usize);
        name.cloned()
            .unwrap_or_else(|| format!("r{}", u64::from(robot) + 1))
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
    let mut ways: Vec<Way> = Vec::new();
    for message in messages {
        match message.fate {
            Fate::Used(way) => ways.push(way),
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
        let durations = ways.iter().map(|way| way.stages_ns()[i]).collect();
        Figures::new(durations).map(|figures| StageFigures { stage, figures })
    };
    let sum = |way: &Way| way.stages_ns().into_iter().fold(0, i64::saturating_add);
    let error = |way: &Way| {
        way.end_to_end_ns()
            .saturating_sub(sum(way))
            .saturating_abs()
    };
    let largest = ways.iter().map(error).max();
    Hop {
        from,
        to,
        messages: ways.len() as u64,
        sent: messages.len() as u64,
        incomplete,
        stages: STAGES.iter().enumerate().filter_map(stage).collect(),
        end_to_end: Figures::new(ways.iter().map(Way::end_to_end_ns).collect()),
        largest_sum_error_s: s_from_ns(largest.unwrap_or(0)),
    }
}

/// Ages of all pairs, in the order of who is used and who uses.
fn ages(pairs: BTreeMap<Link, Vec<i64>>, names: &Names<'_>) -> Vec<Age> {
    let age = |((from, to), ages): (Link, Vec<i64>)| {
        let count = ages.len() as u64;
        Figures::new(ages).map(|figures| Age {
            from: names.of(from),
            to: names.of(to),
            count,
            figures,
        })
    };
    pairs.into_iter().filter_map(age).collect()
}

/// Follows each used message back to the robots whose messages its sender went by.
fn platoon(log: &Log, messages: &[Message], names: &Names<'_>) -> Vec<Age> {
    let ahead = log.sender_to();
    let mut pairs: BTreeMap<Link, Vec<i64>> = BTreeMap::new();
    for message in messages {
        // The front robot goes by nobody: a ring's return only tells it to send again.
        let Fate::Used(way) = message.fate else {
            continue;
        };
        if message.to == 0 {
            continue;
        }
        let applied_ns = way.instants_ns[7];
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

fn loops(log: &Log, names: &Names<'_>) -> Vec<LoopFigures> {
    let mut ticks: BTreeMap<LoopOf, Vec<[i64; 2]>> = BTreeMap::new();
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
    let figures = |(of, times): (LoopOf, Vec<[i64; 2]>)| {
        let late = |&[due, began]: &[i64; 2]| began.saturating_sub(due);
        let lateness: Vec<i64> = times.iter().map(late).collect();
        let more = |pair: &[i64]| pair[1].saturating_sub(pair[0]).saturating_abs();
        let jitter = lateness.windows(2).map(more).collect();
        Figures::new(lateness).map(|late| LoopFigures {
            process: of
                .0
                .map_or_else(|| "plant".to_owned(), |robot| names.of(robot)),
            name: of.1.name(),
            ticks: times.len() as u64,
            left_out: left_out(&times),
            missed: log.missed.get(&of).copied().unwrap_or(0),
            late,
            jitter: Figures::new(jitter),
        })
    };
    ticks.into_iter().filter_map(figures).collect()
}

/// Ticks missing between these, which are due at whole multiples of one period.
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
