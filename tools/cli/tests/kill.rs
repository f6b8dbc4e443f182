//! `kill -9` at random times, each process in turn: a run never hangs, names the process that died, keeps
//! its recording readable and leaves nothing in shared memory.
//!
//! `SLIPSTREAM_KILLS` is the number of kills (100 in `just kill`).
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

use common::{Role, command, is_alive, roles, shared_memory, slipstream, wait_for};
use rustix::process::{Pid, Signal, kill_process};

/// A run that lasts longer than any test.
const RUN: [&str; 6] = [
    "run",
    "--set",
    "duration_s=100000",
    "--out",
    "killed.mcap",
    "--seed=3",
];
/// Longest time from a death to the end of the run.
const LIMIT: Duration = Duration::from_secs(2);
const VICTIMS: [&str; 4] = ["agent", "plant", "recorder", "launcher"];

fn kill(pid: u32, signal: Signal) {
    let pid = Pid::from_raw(i32::try_from(pid).unwrap()).unwrap();
    kill_process(pid, signal).unwrap();
}

/// Starts a run, waits until all processes run and data is recorded, and then for `after`.
fn start(folder: &Path, arguments: &[&str], after: Duration) -> (Child, Vec<Role>) {
    let child = command(folder, arguments).spawn().unwrap();
    let mut processes = Vec::new();
    wait_for("start", Duration::from_secs(20), || {
        processes = roles(child.id());
        let recording = std::fs::metadata(folder.join("killed.mcap")).map_or(0, |m| m.len());
        processes.len() == 5 && recording > 0
    });
    std::thread::sleep(after);
    (child, processes)
}

fn assert_recording(folder: &Path) {
    let path = folder.join("killed.mcap");
    let import = slipstream_recording::read(&path).unwrap();
    assert_eq!(import.recording.robots.len(), 3);
}

fn assert_nothing_left(processes: &[Role]) {
    for role in processes {
        assert!(!is_alive(role.pid), "{role:?} is still running");
    }
    let left = shared_memory(processes[0].folder());
    assert!(left.is_empty(), "{left:?}");
}

/// Kills one process of a run and checks what is left.
fn kill_one(victim: &str, after: Duration) {
    let folder = tempfile::tempdir().unwrap();
    let (launcher, processes) = start(folder.path(), &RUN, after);
    if victim == "launcher" {
        return kill_launcher(folder.path(), launcher, &processes);
    }
    let pid = processes
        .iter()
        .find(|role| role.name() == victim)
        .unwrap()
        .pid;
    let begin = Instant::now();
    kill(pid, Signal::KILL);
    let output = launcher.wait_with_output().unwrap();
    assert!(begin.elapsed() < LIMIT, "{victim}: {:?}", begin.elapsed());
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{victim}: {stderr}");
    let name = if victim == "agent" { "r1" } else { victim };
    assert!(
        stderr.contains(&format!("{name} (pid {pid}) was killed by signal 9")),
        "{stderr}"
    );
    assert_recording(folder.path());
    assert_nothing_left(&processes);
}

fn kill_launcher(folder: &Path, mut launcher: Child, processes: &[Role]) {
    kill(launcher.id(), Signal::KILL);
    launcher.wait().unwrap();
    wait_for("end of the roles", LIMIT, || {
        !processes.iter().any(|role| is_alive(role.pid))
    });
    assert!(slipstream(folder, &["clean"]).status.success());
    assert_recording(folder);
    assert_nothing_left(processes);
}

#[test]
fn a_killed_process_ends_the_run_and_leaves_nothing_behind() {
    let kills = std::env::var("SLIPSTREAM_KILLS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(8);
    // The clock is random enough for kill times that differ from run to run.
    for k in 0..kills {
        let nanos = std::time::SystemTime::UNIX_EPOCH
            .elapsed()
            .unwrap()
            .subsec_nanos();
        let after = Duration::from_millis(u64::from(nanos) % 500);
        kill_one(VICTIMS[k % VICTIMS.len()], after);
    }
}

#[test]
fn an_interrupted_run_ends_cleanly_and_keeps_its_recording() {
    for signal in [Signal::INT, Signal::TERM] {
        let folder = tempfile::tempdir().unwrap();
        let (launcher, processes) = start(folder.path(), &RUN, Duration::from_millis(300));
        let begin = Instant::now();
        kill(launcher.id(), signal);
        let output = launcher.wait_with_output().unwrap();
        assert!(begin.elapsed() < LIMIT, "{:?}", begin.elapsed());
        assert_eq!(output.status.code(), Some(130));
        let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(stdout.contains("until it was interrupted"), "{stdout}");
        assert_recording(folder.path());
        assert_nothing_left(&processes);
    }
}

#[test]
fn two_concurrent_runs_do_not_interact() {
    let folder = tempfile::tempdir().unwrap();
    let run = |json: &str| {
        let arguments = [
            "run",
            "--no-recording",
            "--set",
            "duration_s=5",
            "--json",
            json,
        ];
        command(folder.path(), &arguments).spawn().unwrap()
    };
    let both = [run("a.json"), run("b.json")];
    for child in both {
        assert!(child.wait_with_output().unwrap().status.success());
    }
    let hash = |name: &str| common::read_json(&folder.path().join(name))["state_hash"].clone();
    assert_eq!(hash("a.json"), hash("b.json"));
}

#[test]
fn the_summary_lists_exactly_the_processes_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [&RUN[..], &["--json", "result.json"]].concat();
    let (launcher, processes) = start(folder.path(), &arguments, Duration::from_millis(100));
    kill(launcher.id(), Signal::INT);
    launcher.wait_with_output().unwrap();
    let result = common::read_json(&folder.path().join("result.json"));
    let mut listed: Vec<u64> = result["processes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|process| process["pid"].as_u64().unwrap())
        .collect();
    let mut seen: Vec<u64> = processes.iter().map(|role| u64::from(role.pid)).collect();
    listed.sort_unstable();
    seen.sort_unstable();
    assert_eq!(listed, seen);
    assert_nothing_left(&processes);
}
