//! `slipstream study` on the command line: points, shards, interruption, costs, invalid input.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

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

/// A point of a study has the same results as the run with the same keys as processes, bit for bit.
#[test]
fn a_point_equals_the_run_as_processes() {
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
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
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
    // A shard that is there is kept, one of another study is not.
    let text = String::from_utf8(read("a.json")).unwrap();
    let marked = text.replace("\"runs\": 1,\n      \"max", "\"runs\": 9,\n      \"max");
    assert_ne!(text, marked);
    std::fs::write(folder.path().join("a.json"), &marked).unwrap();
    delay("--shard 1/2 --json a.json --resume");
    assert_eq!(String::from_utf8(read("a.json")).unwrap(), marked);
    delay("--shard 2/2 --json a.json --resume");
    assert!(read("a.json") == read("b.json"));
}

#[test]
fn a_dry_run_prints_costs_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let line = "study delay --dry-run --runs 20000 --delay 0,0.1 --threads 2 --json a.json --report a.html";
    let output = slipstream(folder.path(), &line.split(' ').collect::<Vec<_>>());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.starts_with("144 points, 2880000 runs\nAbout "),
        "{text}"
    );
    let number = |before: &str, after: &str| -> f64 {
        let rest = text.split(before).nth(1).unwrap();
        rest.split(after).next().unwrap().trim().parse().unwrap()
    };
    let (hours, run_s) = (
        number("About ", " core hours"),
        number("of the runs,", " s each"),
    );
    // Both are rounded to two digits.
    assert!(
        (hours * 3600.0 / (run_s * 2_880_000.0) - 1.0).abs() < 0.11,
        "{text}"
    );
    let shards = number("this machine.\n", " shards of about ");
    let minutes = number("shards of about ", " minutes each on 2 cores");
    assert!(
        (shards * minutes * 2.0 / 60.0 / hours - 1.0).abs() < 0.11,
        "{text}"
    );
    assert!((13.0..16.0).contains(&minutes) || shards == 144.0, "{text}");
    let expected = format!(
        "slipstream study delay --runs 20000 --delay 0,0.1 --threads 2 --shard 1/{shards} --json shard-1.json"
    );
    assert_eq!(text.lines().last().unwrap(), expected);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Ctrl-C keeps the finished points in a valid file, with exit code 130.
#[test]
fn an_interrupted_study_keeps_its_points() {
    let folder = tempfile::tempdir().unwrap();
    let grid = "study delay --delay 0,0.1,0.2,0.3 --jitter 0,0.05 --loss 0.1 --k-x 1,2 \
                --torque-limit none --protocol ring,periodic --runs 3";
    let arguments = |more: &str| format!("{grid} {more}");
    // Time for one point on this machine.
    let begin = std::time::Instant::now();
    let line = arguments("--threads 1 --json one.json --shard 32/32");
    let command_line: Vec<&str> = line.split_whitespace().collect();
    assert!(slipstream(folder.path(), &command_line).status.success());
    let one_point = begin.elapsed();
    let line = arguments("--threads 1 --json part.json --report part.html --shard 1/2");
    let command_line: Vec<&str> = line.split_whitespace().collect();
    let child = common::command(folder.path(), &command_line)
        .spawn()
        .unwrap();
    // By then some of the sixteen points are finished, but not all.
    std::thread::sleep(4 * one_point);
    let pid = rustix::process::Pid::from_raw(i32::try_from(child.id()).unwrap()).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert!(String::from_utf8_lossy(&output.stdout).contains("Interrupted"));
    let part = read_json(&folder.path().join("part.json"));
    let points = part["points"].as_array().unwrap();
    assert!((1..16).contains(&points.len()), "{}", points.len());
    assert!(folder.path().join("part.html").exists());
    // The finished points are those of the whole study.
    let line = arguments("--json whole.json --shard 1/2");
    let command_line: Vec<&str> = line.split_whitespace().collect();
    assert!(slipstream(folder.path(), &command_line).status.success());
    let whole = read_json(&folder.path().join("whole.json"));
    let whole = whole["points"].as_array().unwrap();
    assert_eq!(whole.len(), 16);
    assert!(points.iter().all(|point| whole.contains(point)));
    let line = arguments("--json other.json --shard 2/2");
    let command_line: Vec<&str> = line.split_whitespace().collect();
    assert!(slipstream(folder.path(), &command_line).status.success());
    let merge = |file: &str| slipstream(folder.path(), &["study", "merge", file, "other.json"]);
    let refused = merge("part.json");
    let stderr = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{stderr}");
    assert!(
        stderr.contains("shard 1/2: was interrupted") && stderr.lines().count() == 1,
        "{stderr}"
    );
    assert!(merge("whole.json").status.success());
}

#[test]
fn invalid_input_is_reported_in_one_line() {
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
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(
            stderr.contains(place) && stderr.trim_end().lines().count() == 1,
            "{stderr}"
        );
    }
}
