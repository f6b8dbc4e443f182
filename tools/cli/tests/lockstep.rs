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

/// What begins within a run begins at the same instant, with the same states before and behind it.
#[test]
fn changes_within_a_run_have_the_same_states() {
    let folder = tempfile::tempdir().unwrap();
    let text = "base = \"platoon\"
duration_s = 6
links.delay_s = 0.05
[[changes]]
at_s = 2.0005
robot = \"r2\"
effect = \"payload\"
mass_kg = 2
x_m = 0.05
y_m = 0
[[changes]]
at_s = 4
link = \"r2 to r3\"
delay_s = 0.3
[[changes]]
at_s = 3
robot = \"r1\"
effect = \"backlash\"
gap_rad = 0.02
";
    std::fs::write(folder.path().join("changes.toml"), text).unwrap();
    let in_process = run_json(folder.path(), &["changes.toml", "--in-process"]);
    let processes = run_json(folder.path(), &["changes.toml"]);
    assert_eq!(
        deterministic_part(&processes),
        deterministic_part(&in_process)
    );
    let until = |duration_s: &str, more: &[&str]| {
        let set = format!("duration_s={duration_s}");
        let arguments = ["changes.toml", "--in-process", "--set", &set];
        let all = run_json(folder.path(), &[&arguments[..], more].concat());
        all["state_hash"].clone()
    };
    let none = ["--set", "changes=[]"];
    let one = "changes=[{at_s=2.0005, robot='r2', effect='payload', mass_kg=2, x_m=0.05, y_m=0}]";
    assert_eq!(
        until("2.5", &["--set", one]),
        until("2.5", &["--set", &one.replace("mass_kg=2", "mass_kg=2.0")])
    );
    assert_ne!(until("2.5", &["--set", one]), until("2.5", &none));
    let late = one.replace("2.0005", "2.4999");
    assert_eq!(
        until("2.49", &["--set", &late.replace("2.4999", "2.4899999")]),
        until("2.49", &none)
    );
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
