//! The project's most important promise: a run in N + 1 processes and the same run in one process
//! go through the same states, bit for bit, whatever else the machine does.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at what it does not expect"
)]

mod common;

use common::{Load, run_json};
use serde_json::Value;

/// Delay, jitter, loss in bursts; short enough for ten times.
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

/// What must not depend on who ran when: the states, and what robots and links report.
fn essence(result: &Value) -> Value {
    let part = |key: &str| result[key].clone();
    Value::from(vec![part("state_hash"), part("robots"), part("links")])
}

fn compare(robots: &str, protocol: &str, times: u32) {
    let folder = tempfile::tempdir().unwrap();
    let protocol = format!("links.protocol={protocol}");
    let mut arguments = vec!["--robots", robots, "--set", &protocol];
    arguments.extend(LINKS);
    let alone = run_json(folder.path(), &[&arguments[..], &["--in-process"]].concat());
    assert_eq!(alone["state_hash"].as_str().unwrap().len(), 64);
    assert_eq!(alone["processes"].as_array().unwrap().len(), 0);
    let _load = Load::new();
    for time in 0..times {
        let processes = run_json(folder.path(), &arguments);
        let agents = robots.parse::<usize>().unwrap();
        assert_eq!(processes["processes"].as_array().unwrap().len(), agents + 2);
        assert_eq!(
            essence(&processes),
            essence(&alone),
            "{robots} robots, time {time}"
        );
    }
}

#[test]
fn one_robot() {
    compare("1", "ring", 10);
}

#[test]
fn three_robots() {
    compare("3", "ring", 10);
    compare("3", "periodic", 3);
}

#[test]
fn ten_robots() {
    compare("10", "ring", 10);
    compare("10", "periodic", 3);
}

/// The hash sees what it should: another seed, another run.
#[test]
fn another_seed_gives_other_states() {
    let folder = tempfile::tempdir().unwrap();
    let run = |seed| run_json(folder.path(), &["--in-process", "--seed", seed]);
    assert_ne!(run("1")["state_hash"], run("2")["state_hash"]);
}

/// What the recording says does not depend on who ran when either. (Where the file is cut into
/// chunks does: they are made safe by wall time.)
#[test]
fn the_recording_says_the_same_too() {
    let folder = tempfile::tempdir().unwrap();
    let record = |out: &str, more: &[&str]| {
        run_json(
            folder.path(),
            &[&["--set", "duration_s=4", "--out", out], more].concat(),
        );
        let import = slipstream_recording::read(&folder.path().join(out)).unwrap();
        format!("{:?}", import.recording)
    };
    let alone = record("a.mcap", &["--in-process"]);
    assert!(alone.len() > 10_000);
    for _ in 0..3 {
        assert!(
            record("b.mcap", &[]) == alone,
            "a.mcap and b.mcap say different things"
        );
    }
}
