//! Every message and every tick is counted once, and as the run counts it.

use serde_json::Value;
use slipstream_bus::trace::{self, TraceRecord};
use slipstream_trace::{Fate, follow};

use crate::common::{self, read_json, slipstream};
use crate::helpers::traced;

/// With delay, jitter and loss, each message is in one class, and the classes have the counts of the run.
#[test]
fn every_message_is_accounted_for() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "--set",
        "links.protocol=periodic",
        "--set",
        "links.delay_s=0.12",
        "--set",
        "links.jitter_s=0.06",
        "--set",
        "links.loss=0.15",
        "--set",
        "links.burst=3",
    ];
    let (run, answer) = traced(folder.path(), &arguments);
    let hops = answer["hops"].as_array().unwrap();
    assert_eq!(hops.len(), 2);
    for (hop, link) in hops.iter().zip(run["links"].as_array().unwrap()) {
        assert_eq!([&hop["from"], &hop["to"]], [&link["from"], &link["to"]]);
        assert_eq!(hop["sent"], link["sent"]);
        let class = |name: &str| hop["incomplete"][name].as_u64().unwrap();
        assert_eq!(class("lost"), link["lost"].as_u64().unwrap());
        // The run also counts stale messages that arrive after the last outer tick; here they are in flight.
        let stale = class("stale")..=class("stale") + class("under_way");
        assert!(stale.contains(&link["stale"].as_u64().unwrap()));
        assert!(class("lost") > 10 && class("stale") > 0 && class("superseded") > 0);
        assert_eq!(class("untold") + class("receiver_died"), 0);
        let others: u64 = hop["incomplete"]
            .as_object()
            .unwrap()
            .values()
            .map(|n| n.as_u64().unwrap())
            .sum();
        assert_eq!(
            others + hop["messages"].as_u64().unwrap(),
            hop["sent"].as_u64().unwrap()
        );
    }
}

/// The sum of the stages equals the end-to-end latency found by plain search in the records.
#[test]
fn stages_add_up_to_the_latency_in_the_records() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "--in-process",
        "--set",
        "links.delay_s=0.08",
        "--set",
        "links.jitter_s=0.03",
    ];
    traced(folder.path(), &arguments);
    let path = folder.path().join("run.mcap");
    let mut records: Vec<TraceRecord<'static>> = Vec::new();
    slipstream_recording::read_trace(&path, &mut |bytes| {
        let chunk = Vec::leak(bytes.to_vec());
        trace::read(chunk, |record| records.push(record)).is_ok()
    })
    .unwrap();
    let find = |name: &str, matches: &dyn Fn(&TraceRecord<'_>) -> bool, field: &str| {
        let mut records = records.iter();
        let found = records.find(|record| record.name == name && matches(record));
        found.and_then(|record| record.int(field)).unwrap()
    };
    let mut used = 0;
    for message in follow(&slipstream_trace::read(&path).unwrap().log) {
        let Fate::Used(chain) = message.fate else {
            continue;
        };
        used += 1;
        let is_message = |record: &TraceRecord<'_>| {
            [record.int("from"), record.int("seq")]
                == [message.from, message.seq].map(|number| Some(i64::from(number)))
        };
        let sampled_ns = find("sent", &is_message, "sampled_ns");
        let tick_ns = find("taken", &is_message, "tick_ns");
        let follows_tick = |record: &TraceRecord<'_>| {
            record.int("robot") == Some(i64::from(message.to))
                && record.int("tick_ns") >= Some(tick_ns)
        };
        let first_torque_ns = find("applied", &follows_tick, "t_ns");
        let stages = chain.stages_ns();
        assert!(stages.iter().all(|&stage| stage >= 0), "{message:?}");
        assert_eq!(stages.iter().sum::<i64>(), first_torque_ns - sampled_ns);
    }
    assert!(used > 50, "{used}");
}

/// Messages to an agent that is killed are counted as such.
#[test]
fn messages_to_a_dead_agent_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "run",
        "--clock",
        "wall",
        "--set",
        "duration_s=60",
        "--set",
        "links.protocol=periodic",
        "--set",
        "links.delay_s=0.4",
        "--out",
        "run.mcap",
    ];
    let child = common::command(folder.path(), &arguments).spawn().unwrap();
    let mut victim = None;
    common::wait_for("the agents", std::time::Duration::from_secs(20), || {
        let roles = common::roles(child.id());
        let agent = |role: &&common::Role| role.arguments.windows(2).any(|w| w == ["--robot", "1"]);
        victim = roles.iter().find(agent).map(|role| role.pid);
        let recorded = std::fs::metadata(folder.path().join("run.mcap"));
        victim.is_some() && recorded.is_ok_and(|file| file.len() > 20_000)
    });
    let pid = rustix::process::Pid::from_raw(i32::try_from(victim.unwrap()).unwrap()).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::KILL).unwrap();
    assert_eq!(child.wait_with_output().unwrap().status.code(), Some(1));
    let output = slipstream(
        folder.path(),
        &["trace", "run.mcap", "--json", "trace.json"],
    );
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let answer = read_json(&folder.path().join("trace.json"));
    let hops = answer["hops"].as_array().unwrap();
    let died = |from: &str| {
        let hop = hops.iter().find(|hop| hop["from"] == from).unwrap();
        hop["incomplete"]["receiver_died"].as_u64().unwrap()
    };
    // 20 messages per second, each in flight for 0.4 s.
    assert!((4..=20).contains(&died("r1")), "{}", died("r1"));
    assert_eq!(died("r2"), 0);
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.contains("whose receiver died"), "{table}");
    // The answer has every loop, starting with the step of the plant.
    let loops = answer["loops"].as_array().unwrap();
    assert_eq!([&loops[0]["process"], &loops[0]["loop"]], ["plant", "step"]);
    assert_eq!(loops.len(), 7);
    for figures in loops {
        assert!(
            figures["jitter"]["max_s"].as_f64().unwrap() > 0.0,
            "{figures}"
        );
        assert!(figures["missed"].is_u64(), "{figures}");
    }
}

/// The trace has the same missed deadlines as the summary of the run.
#[test]
fn missed_deadlines_agree_with_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let (run, answer) = {
        let _load = common::Load::new();
        traced(folder.path(), &["--clock", "wall", "--set", "duration_s=3"])
    };
    for expected in run["deadlines"].as_array().unwrap() {
        let mut loops = answer["loops"].as_array().unwrap().iter();
        let same = |found: &&Value| {
            found["process"] == expected["process"] && found["loop"] == expected["loop"]
        };
        let found = loops.find(same).unwrap();
        let count = |key: &str| found[key].as_u64().unwrap();
        assert_eq!(
            count("ticks") + count("left_out"),
            expected["ticks"],
            "{found} {expected}"
        );
        assert_eq!(
            count("missed") + count("left_out"),
            expected["missed"],
            "{found} {expected}"
        );
    }
}
