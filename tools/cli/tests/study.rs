//! `slipstream study` and `slipstream reproduce` as commands.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at what it does not expect"
)]

mod common;

use common::{read_json, run_json, slipstream};
use serde_json::Value;

const POINT: [&str; 14] = [
    "--runs",
    "1",
    "--delay",
    "0.1",
    "--jitter",
    "0.05",
    "--loss",
    "0.1",
    "--k-x",
    "1",
    "--torque-limit",
    "none",
    "--protocol",
    "ring",
];

/// A point of a study against the same run in processes, bit for bit.
#[test]
fn a_point_is_the_run_in_processes() {
    let folder = tempfile::tempdir().unwrap();
    let study = [
        "study",
        "delay",
        "--json",
        "study.json",
        "--report",
        "study.html",
    ];
    let output = slipstream(folder.path(), &[&study[..], &POINT].concat());
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words}");
    let study = read_json(&folder.path().join("study.json"));
    let point = &study["points"][0];
    let keys = ["links.delay_s=0.1", "links.jitter_s=0.05", "links.loss=0.1"];
    let set: Vec<&str> = keys.iter().flat_map(|key| ["--set", key]).collect();
    let run = run_json(
        folder.path(),
        &[&["--no-recording", "--seed", "1"], &set[..]].concat(),
    );
    assert_eq!(run["processes"].as_array().unwrap().len(), 4);
    let followers = &run["robots"].as_array().unwrap()[1..];
    let number = |value: &Value| value.as_f64().unwrap();
    let largest = |key: &str| {
        followers
            .iter()
            .map(|robot| number(&robot[key]))
            .fold(0.0, f64::max)
    };
    assert_eq!(
        number(&point["max_desired_speed_m_s"]),
        largest("max_desired_speed_m_s")
    );
    assert_eq!(
        number(&point["max_spacing_error_m"]),
        largest("max_spacing_error_m")
    );
    let slip = followers
        .iter()
        .flat_map(|robot| robot["slip_time_s"].as_array().unwrap());
    assert_eq!(number(&point["slip_time_s"]), slip.map(number).sum::<f64>());
    let page = std::fs::read_to_string(folder.path().join("study.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("slipstream study delay"));
}

#[test]
fn shards_merge_to_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = slipstream(folder.path(), arguments);
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    };
    let grid =
        "--runs 1 --delay 0,0.1 --jitter 0 --loss 0 --k-x 1 --torque-limit none --protocol ring";
    let delay = |more: &str| {
        let line = format!("study delay {grid} {more}");
        run(&line.split(' ').collect::<Vec<_>>());
    };
    delay("--json whole.json --threads 1");
    delay("--shard 1/2 --json a.json");
    delay("--shard 2/2 --json b.json");
    run(&[
        "study",
        "merge",
        "b.json",
        "a.json",
        "--json",
        "merged.json",
    ]);
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(read("merged.json") == read("whole.json"));
}

#[test]
fn what_cannot_be_used_is_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("no.json"), "{}").unwrap();
    for (arguments, place) in [
        (vec!["study", "delay", "--shard", "3/2"], "--shard 3/2"),
        (vec!["study", "delay", "--robots", "1"], "--robots"),
        (vec!["study", "delay", "--loss", "2"], "links.loss"),
        (vec!["study", "merge", "no.json"], "no.json:1"),
        (vec!["study", "merge", "absent.json"], "absent.json"),
    ] {
        let output = slipstream(folder.path(), &arguments);
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {words}");
        assert!(
            words.contains(place) && words.trim_end().lines().count() == 1,
            "{words}"
        );
    }
}
