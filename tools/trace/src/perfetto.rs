//! The run in the Chrome trace event format, for Perfetto: one track per process, arrows along messages.
//!
//! Times are microseconds; each event's arguments hold exact nanoseconds. Every tick is drawn at
//! least 1 µs wide so that arrows can attach to it; in virtual time a tick takes no time. Between hosts a
//! stage may be negative, by less than the clocks tell apart; it is drawn without width.

use std::collections::BTreeSet;

use serde_json::{Value, json};
use slipstream_bus::message::RobotIndex;

use crate::chain::{Chain, Fate, STAGES, TracedMessage, messages};
use crate::log::{Log, Note};
use crate::names::Names;

/// Process id of the plant in the trace.
const PLANT_PID: u32 = 1;
/// Names and process ids of the processes that are neither the plant nor a robot.
const OTHER_PIDS: [(&str, u32); 5] = [
    ("launcher", 2),
    ("recorder", 3),
    ("run", 4),
    ("hosts", 5),
    ("relay", 6),
];
/// Process id of the first robot; robot i has this plus i.
const FIRST_ROBOT_PID: u32 = 10;
/// Thread id of a robot's outer loop.
const OUTER_TID: u32 = 1;
/// Thread id of a robot's inner loop.
const INNER_TID: u32 = 2;
/// Category of slices and arrows; viewers attach arrows to slices of the same category.
const CATEGORY: &str = "position";

/// The trace as JSON, with every tick, message and note of the run; `names` by the robots' index.
pub fn timeline(log: &Log, names: &[String]) -> Value {
    let names = Names(names);
    let mut events = track_names(log, &names);
    for ((robot, due_ns), tick) in log.outer_ticks() {
        let times = [tick.began_ns, tick.done_ns];
        events.push(slice("outer", track(robot, OUTER_TID), times, due_ns));
    }
    for ((robot, due_ns), tick) in log.inner_ticks() {
        let times = [tick.began_ns, tick.done_ns];
        events.push(slice("inner", track(robot, INNER_TID), times, due_ns));
    }
    for ((robot, due_ns), taken_ns) in log.torques() {
        events.push(slice("torque", at_plant(robot), [taken_ns; 2], due_ns));
    }
    for [due_ns, began_ns, done_ns] in log.steps() {
        events.push(slice("step", [PLANT_PID, 0], [began_ns, done_ns], due_ns));
    }
    events.extend(log.notes.iter().map(|note| note_event(note, &names)));
    for message in messages(log) {
        if let Fate::Used(chain) = message.fate {
            let from = names.of(message.from);
            let id = format!("{from}:{}", message.seq);
            stages(&mut events, &id, message.to, &chain);
            arrows(&mut events, &id, &message, &chain);
        }
    }
    // Viewers expect the events of an arrow in the order of time.
    let t = |event: &Value| event["ts"].as_f64().unwrap_or(f64::NEG_INFINITY);
    events.sort_by(|a, b| t(a).total_cmp(&t(b)));
    json!({"traceEvents": events, "displayTimeUnit": "ns"})
}

fn track(robot: RobotIndex, thread: u32) -> [u32; 2] {
    [robot.saturating_add(FIRST_ROBOT_PID), thread]
}

fn at_plant(robot: RobotIndex) -> [u32; 2] {
    [PLANT_PID, robot.saturating_add(1)]
}

fn micros(ns: i64) -> f64 {
    ns as f64 / 1e3
}

fn track_names(log: &Log, names: &Names<'_>) -> Vec<Value> {
    let title = |what: &str, [pid, tid]: [u32; 2], name: &str| json!({"ph": "M", "name": what, "pid": pid, "tid": tid, "args": {"name": name}});
    let robots: BTreeSet<RobotIndex> = log.inner_ticks().map(|(tick, _)| tick.0).collect();
    let mut titles = vec![title("process_name", [PLANT_PID, 0], "plant")];
    for (name, pid) in OTHER_PIDS {
        if log.notes.iter().any(|note| note.process == name) {
            titles.push(title("process_name", [pid, 0], name));
        }
    }
    for robot in robots {
        let name = names.of(robot);
        titles.push(title("thread_name", at_plant(robot), &name));
        titles.push(title("process_name", track(robot, 0), &name));
        titles.push(title("thread_name", track(robot, OUTER_TID), "outer loop"));
        titles.push(title("thread_name", track(robot, INNER_TID), "inner loop"));
    }
    titles
}

fn slice(name: &str, [pid, tid]: [u32; 2], [t_ns, done_ns]: [i64; 2], due_ns: i64) -> Value {
    let dur = micros(done_ns.saturating_sub(t_ns)).max(1.0);
    json!({"ph": "X", "cat": CATEGORY, "name": name, "pid": pid, "tid": tid, "ts": micros(t_ns), "dur": dur,
           "args": {"t_ns": t_ns, "done_ns": done_ns, "due_ns": due_ns}})
}

/// A span or event that belongs to no chain and no tick, on the first track of its process.
fn note_event(note: &Note, names: &Names<'_>) -> Value {
    let other = OTHER_PIDS.iter().find(|(name, _)| *name == note.process);
    let robot = || names.0.iter().position(|name| *name == note.process);
    let pid = match (other, robot().and_then(|robot| u32::try_from(robot).ok())) {
        (Some((_, pid)), _) => *pid,
        (None, Some(robot)) => track(robot, 0)[0],
        (None, None) => PLANT_PID,
    };
    let (name, ts) = (&note.name, micros(note.begin_ns));
    let args = &note.fields;
    match note.end_ns {
        Some(end_ns) => {
            let dur = micros(end_ns.saturating_sub(note.begin_ns));
            json!({"ph": "X", "name": name, "pid": pid, "tid": 0, "ts": ts, "dur": dur, "args": args})
        }
        None => json!({"ph": "i", "s": "t", "name": name, "pid": pid, "tid": 0, "ts": ts,
                       "args": args}),
    }
}

/// The stages one after the other, as an asynchronous track at the receiver.
fn stages(events: &mut Vec<Value>, id: &str, to: RobotIndex, chain: &Chain) {
    let [pid, tid] = track(to, OUTER_TID);
    let mut end_ns = chain.instants_ns[0];
    for (stage, pair) in STAGES.iter().zip(chain.instants_ns.windows(2)) {
        let length_ns = pair[1].saturating_sub(pair[0]);
        // After a negative stage, what follows is drawn from where the stage before ended.
        let begin_ns = end_ns;
        end_ns = pair[1].max(begin_ns);
        for (ph, t_ns) in [("b", begin_ns), ("e", end_ns)] {
            events.push(
                json!({"ph": ph, "cat": "way", "id": id, "name": stage, "pid": pid, "tid": tid,
                       "ts": micros(t_ns), "args": {"length_ns": length_ns}}),
            );
        }
    }
}

/// Arrow: sender's tick → receiver's outer tick → receiver's inner tick → plant step.
fn arrows(events: &mut Vec<Value>, id: &str, message: &TracedMessage, chain: &Chain) {
    let [_, sender, _, _, _, outer, inner, plant] = chain.instants_ns;
    let mut ticks = [
        (track(message.from, OUTER_TID), sender),
        (track(message.to, OUTER_TID), outer),
        (track(message.to, INNER_TID), inner),
        (at_plant(message.to), plant),
    ];
    // Clocks of several hosts may tell them in another order.
    ticks.sort_by_key(|(_, t_ns)| *t_ns);
    for (ph, ([pid, tid], t_ns)) in ["s", "t", "t", "f"].into_iter().zip(ticks) {
        events.push(
            json!({"ph": ph, "cat": CATEGORY, "id": id, "name": "position", "bp": "e",
                   "pid": pid, "tid": tid, "ts": micros(t_ns)}),
        );
    }
}
