//! Determinism: a run as N + 1 processes and the same run in one process have the same states, bit for bit,
//! under any load of the machine.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use common::{Load, run_json};
use serde_json::Value;

/// Delay, jitter and loss in bursts; short enough to run ten times.
const LINKS: [&str; 12] = [
    "--seed",
    "7",
    "--set",
    "duration_s=6",
    "--set",
    "links.delay_s=0.08",
    "--set",
    "links.jitter_s=0.05",
    "--set",
    "links.loss=0.1",
    "--set",
    "links.burst=3",
];

/// The results that must not depend on scheduling: states, and reports of robots and links.
fn deterministic_part(result: &Value) -> Value {
    let part = |key: &str| result[key].clone();
    Value::from(vec![part("state_hash"), part("robots"), part("links")])
}

/// Compares `times` runs as processes under load with one run in one process.
fn assert_same_states(robots: &str, protocol: &str, times: u32) {
    let folder = tempfile::tempdir().unwrap();
    let protocol = format!("links.protocol={protocol}");
    let mut arguments = vec!["--robots", robots, "--set", &protocol];
    arguments.extend(LINKS);
    let in_process = run_json(folder.path(), &[&arguments[..], &["--in-process"]].concat());
    assert_eq!(in_process["state_hash"].as_str().unwrap().len(), 64);
    assert_eq!(in_process["processes"].as_array().unwrap().len(), 0);
    let _load = Load::new();
    for time in 0..times {
        let processes = run_json(folder.path(), &arguments);
        let agents = robots.parse::<usize>().unwrap();
        assert_eq!(processes["processes"].as_array().unwrap().len(), agents + 2);
        assert_eq!(
            deterministic_part(&processes),
            deterministic_part(&in_process),
            "{robots} robots, time {time}"
        );
    }
}

#[test]
fn one_robot_has_the_same_states() {
    assert_same_states("1", "ring", 10);
}

#[test]
fn three_robots_have_the_same_states() {
    assert_same_states("3", "ring", 10);
    assert_same_states("3", "periodic", 3);
}

#[test]
fn ten_robots_have_the_same_states() {
    assert_same_states("10", "ring", 10);
    assert_same_states("10", "periodic", 3);
}

/// The hash is sensitive: another seed gives another hash.
#[test]
fn another_seed_gives_other_states() {
    let folder = tempfile::tempdir().unwrap();
    let run = |seed| run_json(folder.path(), &["--in-process", "--seed", seed]);
    assert_ne!(run("1")["state_hash"], run("2")["state_hash"]);
}

/// The data of a recording does not depend on scheduling either. (Its chunk boundaries do, because the
/// recorder flushes by wall time.)
#[test]
fn recordings_hold_the_same_data() {
    let folder = tempfile::tempdir().unwrap();
    let record = |out: &str, more: &[&str]| {
        run_json(
            folder.path(),
            &[&["--set", "duration_s=4", "--force", "--out", out], more].concat(),
        );
        let import = slipstream_recording::read(&folder.path().join(out)).unwrap();
        format!("{:?}", import.recording)
    };
    let in_process = record("a.mcap", &["--in-process"]);
    assert!(in_process.len() > 10_000);
    for _ in 0..3 {
        assert!(
            record("b.mcap", &[]) == in_process,
            "a.mcap and b.mcap hold different data"
        );
    }
}
