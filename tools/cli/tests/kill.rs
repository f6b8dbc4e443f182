//! `kill -9` at random moments, each process in turn: a run never hangs, names the process that died, keeps
//! its recording readable, and leaves neither processes nor, after the next run, files.
//!
//! `SLIPSTREAM_KILLS` is the number of kills (1000 in `just kill`).
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;
use std::time::{Duration, Instant};

use common::faults::{
    LONG_RUN, assert_no_dead_runs, assert_recording, count, process, processes_in, random_time,
    signal, start,
};
use common::programs::example;
use common::{Role, command, is_alive, roles, shared_memory, slipstream, wait_for};
use rustix::process::Signal;

/// Longest time from a death to the end of the run.
const LIMIT: Duration = Duration::from_secs(3);
/// The victims, each killed in a running run and while its run starts.
const VICTIMS: [&str; 4] = ["r1", "plant", "recorder", "launcher"];

fn assert_nothing_left(processes: &[Role]) {
    for role in processes {
        assert!(!is_alive(role.pid), "{role:?} is still running");
    }
    let left = shared_memory(processes[0].folder());
    assert!(left.is_empty(), "{left:?}");
}

/// Kills one process of a run that goes on, and checks what is left.
fn kill_running(victim: &str, more: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let (launcher, processes) = start(folder.path(), &[&LONG_RUN[..], more].concat());
    std::thread::sleep(random_time(Duration::from_millis(500)));
    if victim == "launcher" {
        kill_launcher(folder.path(), launcher);
        return assert_nothing_left(&processes);
    }
    let pid = process(&processes, victim).pid;
    signal(pid, Signal::KILL);
    assert_death_is_said(launcher, victim, pid);
    assert_recording(folder.path());
    assert_nothing_left(&processes);
}

/// Kills one process while its run starts, at most 20 ms after it began, and checks what is left.
fn kill_starting(victim: &str, more: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [&LONG_RUN[..], more].concat();
    let launcher = command(folder.path(), &arguments).spawn().unwrap();
    let (id, after) = (launcher.id(), random_time(Duration::from_millis(20)));
    if victim == "launcher" {
        std::thread::sleep(after);
        return kill_launcher(folder.path(), launcher);
    }
    let mut pid = None;
    wait_for("start", Duration::from_secs(20), || {
        pid = roles(id)
            .iter()
            // A program is asked for its parameters before the run.
            .find(|role| role.is(victim) && !role.describes())
            .map(|role| role.pid);
        pid.is_some()
    });
    std::thread::sleep(after);
    signal(pid.unwrap(), Signal::KILL);
    assert_death_is_said(launcher, victim, pid.unwrap());
    assert_recording(folder.path());
    assert_eq!(processes_in(folder.path()), [0; 0]);
}

fn assert_death_is_said(launcher: std::process::Child, victim: &str, pid: u32) {
    let begin = Instant::now();
    let output = launcher.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    let taken = begin.elapsed();
    assert!(taken < LIMIT, "{victim}: {taken:?}: {stderr}");
    assert_eq!(output.status.code(), Some(1), "{victim}: {stderr}");
    let said = format!("{victim} (pid {pid}");
    let line = stderr.lines().find(|line| line.contains(&said));
    let is_told = line.is_some_and(|line| line.contains(") was killed by signal 9"));
    assert!(is_told, "{said}: {stderr}");
}

/// Kills the launcher. Its processes end, and the next run removes its files.
fn kill_launcher(folder: &Path, mut launcher: std::process::Child) {
    signal(launcher.id(), Signal::KILL);
    launcher.wait().unwrap();
    wait_for("end of the processes", LIMIT, || {
        processes_in(folder).is_empty()
    });
    assert_recording(folder);
    let next = ["run", "--no-recording", "--set", "duration_s=0.1"];
    assert!(slipstream(folder, &next).status.success());
    assert_no_dead_runs();
}

#[test]
fn a_killed_process_ends_the_run_and_leaves_nothing_behind() {
    let program = example("paper_law");
    for k in 0..count("SLIPSTREAM_KILLS", 16) {
        let victim = VICTIMS[k % VICTIMS.len()];
        // Every other round with programs of one's own.
        let more: &[&str] = match (k / VICTIMS.len() / 2).is_multiple_of(2) {
            true => &[],
            false => &["--agent", &program],
        };
        if (k / VICTIMS.len()).is_multiple_of(2) {
            kill_running(victim, more);
        } else {
            kill_starting(victim, more);
        }
        if (k + 1).is_multiple_of(100) {
            eprintln!("{} processes killed", k + 1);
        }
    }
}

#[test]
fn an_interrupted_run_ends_cleanly_and_keeps_its_recording() {
    for sent in [Signal::INT, Signal::TERM] {
        let folder = tempfile::tempdir().unwrap();
        let (launcher, processes) = start(folder.path(), &LONG_RUN);
        std::thread::sleep(Duration::from_millis(300));
        let begin = Instant::now();
        signal(launcher.id(), sent);
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
    let arguments = [&LONG_RUN[..], &["--json", "result.json"]].concat();
    let (launcher, processes) = start(folder.path(), &arguments);
    signal(launcher.id(), Signal::INT);
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
