//! Hung processes (SIGSTOP) at random moments, each role in turn, on both clocks: the run names the one
//! that hangs as soon as `watchdog_s` has passed, ends, and keeps its recording.
//!
//! `SLIPSTREAM_HANGS` is the number of hangs of each role (100 in `just hang`).
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::time::{Duration, Instant};

use common::faults::{
    LONG_RUN, assert_recording, count, process, processes_in, random_time, signal, start,
};
use common::programs::example;
use common::{read_json, wait_for};
use rustix::process::Signal;

/// The key `watchdog_s` of these runs.
const WATCHDOG: Duration = Duration::from_secs(1);
/// Longest time from the hang to its name on a machine that is busy with other tests. The long form
/// prints the times.
const LIMIT: Duration = Duration::from_secs(10);

/// Starts a run, stops one of its processes, and returns how long it took until the run named it,
/// with the exit code.
fn hang(folder: &Path, victim: &str, more: &[&str]) -> (Duration, Option<i32>) {
    let arguments = [&LONG_RUN[..], &["--set", "watchdog_s=1"], more].concat();
    let (mut launcher, processes) = start(folder, &arguments);
    std::thread::sleep(random_time(Duration::from_millis(300)));
    let pid = process(&processes, victim).pid;
    let begin = Instant::now();
    signal(pid, Signal::STOP);
    let said = format!("{victim} (pid {pid}");
    let mut lines = BufReader::new(launcher.stderr.take().unwrap()).lines();
    let line = lines
        .find(|line| line.as_ref().unwrap().contains("(pid"))
        .unwrap();
    let named = begin.elapsed();
    let is_told = |line: &String| line.contains(&said) && line.contains(") hangs");
    assert!(line.as_ref().is_ok_and(is_told), "{said}: {line:?}");
    assert!(named < LIMIT, "{victim}: {named:?}");
    lines.for_each(|line| eprintln!("{}", line.unwrap()));
    let code = launcher.wait().unwrap().code();
    assert_recording(folder);
    assert_eq!(processes_in(folder), [0; 0]);
    (named, code)
}

#[test]
fn a_process_that_hangs_is_named_and_ends_the_run() {
    let each = count("SLIPSTREAM_HANGS", 4);
    let program = example("paper_law");
    for victim in ["r1", "plant", "recorder"] {
        let mut longest = Duration::ZERO;
        for k in 0..each {
            let clock = ["virtual", "wall"][k % 2];
            let folder = tempfile::tempdir().unwrap();
            let mut more = vec!["--clock", clock];
            if (k / 2) % 2 == 1 {
                more.extend(["--agent", &program]);
            }
            let (named, code) = hang(folder.path(), victim, &more);
            assert_eq!(code, Some(1), "{victim}, {clock}");
            longest = longest.max(named);
        }
        eprintln!("{victim}: {each} hangs, named after at most {longest:.2?}");
        if each >= 100 {
            // Alone on a machine, as the long form should be.
            assert!(longest < WATCHDOG + Duration::from_secs(1), "{longest:?}");
        }
    }
}

/// What a hung agent left out counts as missed, and the others drive on.
#[test]
fn a_run_goes_on_without_an_agent_that_hangs() {
    let folder = tempfile::tempdir().unwrap();
    let more = [
        "--clock",
        "wall",
        "--set",
        "on_death=continue",
        "--set",
        "duration_s=5",
        "--json",
        "result.json",
    ];
    let (_, code) = hang(folder.path(), "r1", &more);
    assert_eq!(code, Some(1));
    let result = read_json(&folder.path().join("result.json"));
    let duration_s = result["duration_s"].as_f64().unwrap();
    assert!((duration_s - 5.0).abs() < 1e-9, "{duration_s}");
    let counts = |robot: &str| {
        let loops = result["deadlines"].as_array().unwrap();
        let inner = loops
            .iter()
            .find(|counts| counts["process"] == robot && counts["loop"] == "inner");
        let of = |key: &str| inner.unwrap()[key].as_u64().unwrap();
        (of("ticks"), of("missed"))
    };
    // 50 times a second for 5 s; it hung in the first.
    let (ticks, missed) = counts("r1");
    assert!(ticks.abs_diff(250) <= 1, "{ticks}");
    assert!((150..=250).contains(&missed), "{missed}");
    assert!(counts("r2").1 < 25, "{:?}", counts("r2"));
}

/// A recorder that is held up for less than `watchdog_s` loses nothing.
#[test]
fn a_recorder_that_is_held_up_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        &LONG_RUN[..],
        &[
            "--clock",
            "wall",
            "--set",
            "duration_s=4",
            "--json",
            "result.json",
        ],
    ]
    .concat();
    let (mut launcher, processes) = start(folder.path(), &arguments);
    let pid = process(&processes, "recorder").pid;
    signal(pid, Signal::STOP);
    std::thread::sleep(Duration::from_millis(1500));
    signal(pid, Signal::CONT);
    wait_for("end", Duration::from_secs(30), || {
        launcher.try_wait().unwrap().is_some()
    });
    let result = read_json(&folder.path().join("result.json"));
    assert_eq!(result["lost_records"], 0);
    assert_eq!(launcher.wait().unwrap().code(), Some(0));
}
