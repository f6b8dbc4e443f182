//! Resources that run out: disk, file size, shared memory, file descriptors, memory. The run says which
//! one, with the path where there is one, ends with exit code 1, or 2 if it could not begin, and leaves nothing
//! in shared memory.
//!
//! Needs no privilege: /dev/full is a full disk, `ulimit` sets the limits, and a user namespace, where the
//! system permits one, has a /dev/shm of its own. `SLIPSTREAM_FULL` repeats each case (20 in `just full`).
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use common::faults::{assert_no_dead_runs, count};
use common::{command, read_json, slipstream};

/// Longest time from the start of a run whose resources run out to its end.
const LIMIT: Duration = Duration::from_secs(60);

/// Runs a shell line in which `$S` is `slipstream`.
fn shell(folder: &Path, line: &str) -> Output {
    let mut shell = Command::new("bash");
    shell.current_dir(folder).args(["-c", line]);
    let begin = Instant::now();
    let output = shell
        .env("S", env!("CARGO_BIN_EXE_slipstream"))
        .env_remove("RUST_LOG")
        .output()
        .unwrap();
    assert!(begin.elapsed() < LIMIT, "{line}: {:?}", begin.elapsed());
    output
}

/// The begin of a shell line that runs the rest, in quotes, where it may mount file systems. `None` where
/// the system permits no user namespaces.
fn namespace() -> Option<&'static str> {
    let own = "unshare --user --map-root-user --mount bash -c";
    let folder = tempfile::tempdir().unwrap();
    let mounts = format!("{own} 'mount -t tmpfs -o size=1m tmpfs /dev/shm'");
    let permitted = shell(folder.path(), &mounts).status.success();
    if !permitted {
        eprintln!("SKIPPED: the system permits no user namespaces");
    }
    permitted.then_some(own)
}

/// Runs a line repeatedly: it must end with this exit code and say these words, and leave nothing.
fn assert_says(line: &str, code: i32, words: &[&str]) {
    for _ in 0..count("SLIPSTREAM_FULL", 1) {
        let folder = tempfile::tempdir().unwrap();
        let output = shell(folder.path(), line);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{line}: {stderr}");
        for word in words {
            assert!(stderr.contains(word), "{line}: {word}: {stderr}");
        }
        let names = std::fs::read_dir(folder.path()).unwrap().flatten();
        let names: Vec<_> = names.map(|entry| entry.file_name()).collect();
        let partial = |name: &std::ffi::OsString| name.to_string_lossy().starts_with(".slipstream");
        assert!(!names.iter().any(partial), "{line}: {names:?}");
        assert_no_dead_runs();
    }
}

#[test]
fn a_full_disk_is_said_by_the_running_run() {
    let line = "$S run --set duration_s=100000 --out /dev/full";
    assert_says(line, 1, &["recorder (pid", "/dev/full", "no space left"]);
}

#[test]
fn a_file_size_limit_is_said_by_the_running_run() {
    let line = "ulimit -f 8000; $S run --set duration_s=100000 --out big.mcap";
    assert_says(
        line,
        1,
        &["recorder (pid", "big.mcap", "no space left", "ulimit -f"],
    );
    let line = "ulimit -f 100; $S run --out big.mcap";
    assert_says(line, 2, &["ulimit -f: 3 robots need", "--in-process"]);
    let line = "ulimit -f 100; $S run --in-process --set duration_s=100 --out big.mcap";
    assert_says(line, 1, &["big.mcap", "no space left", "ulimit -f"]);
}

/// A disk that fills while the run goes on: it is said at once, and on the wall clock the run can go on
/// without its recording.
#[test]
fn a_disk_that_fills_is_said_at_once() {
    let Some(own) = namespace() else { return };
    let run = "mkdir disk; mount -t tmpfs -o size=100k tmpfs disk; \
         $S run --clock wall --set duration_s=6 --set recording.state_period_s=0.005";
    for (on_death, simulated) in [("stop", false), ("continue", true)] {
        let line = format!("{run} --set on_death={on_death} --out disk/run.mcap --json run.json");
        let folder = tempfile::tempdir().unwrap();
        let output = shell(folder.path(), &format!("{own} '{line}'"));
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert!(
            stderr.contains("disk/run.mcap: cannot be written: no space left"),
            "{stderr}"
        );
        let duration_s = read_json(&folder.path().join("run.json"))["duration_s"].as_f64();
        assert_eq!(
            duration_s == Some(6.0),
            simulated,
            "{duration_s:?}: {stderr}"
        );
    }
}

#[test]
fn too_few_descriptors_are_said_before_the_run() {
    let line = "ulimit -n 60; $S run";
    assert_says(line, 2, &["ulimit -n: 3 robots need", "60 are allowed"]);
}

/// Address space is the memory that a limit without privileges can take away.
#[test]
fn too_little_memory_ends_in_words() {
    for kilobytes in [12_000, 20_000] {
        let line = format!(
            "ulimit -v {kilobytes}; $S run --no-recording --set duration_s=1; \
             code=$?; test $code != 0 || echo enough >&2; exit $(( code > 0 ))"
        );
        let folder = tempfile::tempdir().unwrap();
        let output = shell(folder.path(), &line);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!stderr.is_empty(), "{line}");
        assert_no_dead_runs();
    }
}

/// One cause has one exit code, whatever the command: a full disk is a failure, a path that cannot be
/// written to is invalid input.
#[test]
fn one_cause_has_one_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let run = [
        "run",
        "--in-process",
        "--set",
        "duration_s=1",
        "--out",
        "run.mcap",
    ];
    assert!(slipstream(folder.path(), &run).status.success());
    std::fs::write(folder.path().join("file"), "").unwrap();
    let commands: [&[&str]; 7] = [
        &[
            "run",
            "--in-process",
            "--no-recording",
            "--set",
            "duration_s=1",
            "--json",
        ],
        &["run", "--set", "duration_s=1", "--out"],
        &["check", "run.mcap", "--json"],
        &["import", "run.mcap", "--out"],
        &["trace", "run.mcap", "--json"],
        &["effects", "--json"],
        &["study", "delay", "--delay", "0", "--runs", "1", "--json"],
    ];
    for words in commands {
        for (path, code) in [("/dev/full", 1), ("missing/file", 2), ("file/file", 2)] {
            let output = slipstream(folder.path(), &[words, &[path]].concat());
            let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(
                output.status.code(),
                Some(code),
                "{words:?} {path}: {stderr}"
            );
            assert!(stderr.contains(path), "{words:?}: {stderr}");
        }
    }
}

/// A /dev/shm that another program fills while the run goes on.
#[test]
fn full_shared_memory_ends_in_words() {
    let Some(own) = namespace() else { return };
    let folder = tempfile::tempdir().unwrap();
    let before = "mount -t tmpfs -o size=3m tmpfs /dev/shm; $S run";
    assert_says(
        &format!("{own} '{before}'"),
        2,
        &["/dev/shm: 3 robots need"],
    );
    let during = "mount -t tmpfs -o size=20m tmpfs /dev/shm; \
         (sleep 1; head -c 30M /dev/zero > /dev/shm/other 2> /dev/null) & \
         $S run --clock wall --set duration_s=3 --no-recording; code=$?; \
         wait; ls /dev/shm | grep -v other >&2; exit $code";
    for _ in 0..count("SLIPSTREAM_FULL", 1) {
        let output = shell(folder.path(), &format!("{own} '{during}'"));
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        // Nothing more is needed once a run has begun, or a process says what it misses.
        let said = stderr.contains("SIGBUS") || stderr.contains("/dev/shm");
        assert!(output.status.success() || said, "{stderr}");
        assert!(!stderr.contains("slipstream-"), "left behind: {stderr}");
    }
}

/// Two runs with one recording, at once: one is refused, and the recording of the other is whole.
#[test]
fn the_second_of_two_runs_with_one_recording_is_refused() {
    for _ in 0..count("SLIPSTREAM_FULL", 2) {
        let folder = tempfile::tempdir().unwrap();
        let arguments = [
            "run",
            "--clock",
            "wall",
            "--set",
            "duration_s=1.5",
            "--out",
            "one.mcap",
            // It permits to replace a recording, not to disturb one.
            "--force",
        ];
        let runs = [0, 1].map(|_| command(folder.path(), &arguments).spawn().unwrap());
        let outputs = runs.map(|run| run.wait_with_output().unwrap());
        let mut codes = outputs.each_ref().map(|output| output.status.code());
        codes.sort_unstable();
        let stderr = outputs.map(|output| String::from_utf8_lossy(&output.stderr).into_owned());
        assert_eq!(codes, [Some(0), Some(2)], "{stderr:?}");
        let said = "one.mcap: cannot be written: another run is recording to it";
        assert!(
            stderr.iter().any(|stderr| stderr.contains(said)),
            "{stderr:?}"
        );
        let import = slipstream_recording::read(&folder.path().join("one.mcap")).unwrap();
        assert_eq!(import.warnings, [""; 0]);
        assert_eq!(import.recording.robots.len(), 3);
    }
}
