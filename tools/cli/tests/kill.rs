//! `kill -9` at random moments on everybody in turn: a run never hangs, names who died, keeps its
//! recording readable and leaves nothing in shared memory.
//!
//! `SLIPSTREAM_KILLS` sets how often (100 in `just kill`).
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at what it does not expect"
)]

mod common;

use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

use common::{Role, command, lives, roles, shared_memory, slipstream, wait_for};
use rustix::process::{Pid, Signal, kill_process};

/// Longer than any test waits.
const RUN: [&str; 6] = [
    "run",
    "--set",
    "duration_s=100000",
    "--out",
    "killed.mcap",
    "--seed=3",
];
/// Nothing takes longer after a death.
const LIMIT: Duration = Duration::from_secs(2);
const VICTIMS: [&str; 4] = ["agent", "plant", "recorder", "launcher"];

fn kill(pid: u32, signal: Signal) {
    let pid = Pid::from_raw(i32::try_from(pid).unwrap()).unwrap();
    kill_process(pid, signal).unwrap();
}

/// Starts a run and waits until it is well under way.
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
        assert!(!lives(role.pid), "{role:?} still lives");
    }
    let left = shared_memory(processes[0].folder());
    assert!(left.is_empty(), "{left:?}");
}

/// Kills one of a run and looks at what is left.
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
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{victim}: {words}");
    let name = if victim == "agent" { "r1" } else { victim };
    assert!(
        words.contains(&format!("{name} (pid {pid}) was killed by signal 9")),
        "{words}"
    );
    assert_recording(folder.path());
    assert_nothing_left(&processes);
}

fn kill_launcher(folder: &Path, mut launcher: Child, processes: &[Role]) {
    kill(launcher.id(), Signal::KILL);
    launcher.wait().unwrap();
    wait_for("end of the roles", LIMIT, || {
        !processes.iter().any(|role| lives(role.pid))
    });
    assert!(slipstream(folder, &["clean"]).status.success());
    assert_recording(folder);
    assert_nothing_left(processes);
}

#[test]
fn whoever_dies_the_run_ends_and_nothing_is_left() {
    let kills = std::env::var("SLIPSTREAM_KILLS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(8);
    // Moments that differ from run to run need no better chance than the clock's.
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
fn an_interrupted_run_ends_in_order_and_keeps_its_recording() {
    for signal in [Signal::INT, Signal::TERM] {
        let folder = tempfile::tempdir().unwrap();
        let (launcher, processes) = start(folder.path(), &RUN, Duration::from_millis(300));
        let begin = Instant::now();
        kill(launcher.id(), signal);
        let output = launcher.wait_with_output().unwrap();
        assert!(begin.elapsed() < LIMIT, "{:?}", begin.elapsed());
        assert_eq!(output.status.code(), Some(130));
        let words = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(words.contains("until it was interrupted"), "{words}");
        assert_recording(folder.path());
        assert_nothing_left(&processes);
    }
}

#[test]
fn two_runs_at_once_do_not_meet() {
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
fn the_processes_of_the_answer_live_during_the_run_and_not_after() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [&RUN[..], &["--json", "result.json"]].concat();
    let (launcher, processes) = start(folder.path(), &arguments, Duration::from_millis(100));
    kill(launcher.id(), Signal::INT);
    launcher.wait_with_output().unwrap();
    let result = common::read_json(&folder.path().join("result.json"));
    let mut told: Vec<u64> = result["processes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|process| process["pid"].as_u64().unwrap())
        .collect();
    let mut seen: Vec<u64> = processes.iter().map(|role| u64::from(role.pid)).collect();
    told.sort_unstable();
    seen.sort_unstable();
    assert_eq!(told, seen);
    assert_nothing_left(&processes);
}
