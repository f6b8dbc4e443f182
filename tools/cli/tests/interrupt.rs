//! Ctrl-C: every command ends within a second or so with exit code 130, without partial files and without
//! touching what was there before.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;
use std::time::{Duration, Instant};

use common::faults::signal;
use common::{command, slipstream};
use rustix::process::Signal;

/// Longest time from the signal to the end, on a machine that is busy with other tests.
const LIMIT: Duration = Duration::from_secs(5);

/// Starts a command, interrupts it after a while, and checks its end.
fn interrupt(folder: &Path, arguments: &[&str], after: Duration) {
    let mut child = command(folder, arguments).spawn().unwrap();
    std::thread::sleep(after);
    assert!(
        child.try_wait().unwrap().is_none(),
        "{arguments:?} ended by itself"
    );
    let begin = Instant::now();
    signal(child.id(), Signal::INT);
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{arguments:?}: {stderr}");
    assert!(
        begin.elapsed() < LIMIT,
        "{arguments:?}: {:?}",
        begin.elapsed()
    );
    let names = std::fs::read_dir(folder).unwrap().flatten();
    for name in names.map(|entry| entry.file_name()) {
        let name = name.to_string_lossy().into_owned();
        assert!(!name.starts_with(".slipstream"), "{arguments:?}: {name}");
    }
}

#[test]
fn commands_that_compute_end_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let record = [
        "run",
        "--in-process",
        "--set",
        "duration_s=1000",
        "--out",
        "long.mcap",
    ];
    let platoon = [&record[..], &["--set", "recording.state_period_s=0.002"]].concat();
    assert!(slipstream(folder.path(), &platoon).status.success());
    let after = Duration::from_millis(150);
    let commands: [&[&str]; 5] = [
        &[
            "run",
            "--in-process",
            "--set",
            "duration_s=100000",
            "--out",
            "other.mcap",
        ],
        &["import", "long.mcap", "--out", "imported.mcap"],
        &["export", "long.mcap", "--out", "exported"],
        &["check", "long.mcap", "--json", "check.json"],
        &["trial", "--cases", "200", "--out", "trial"],
    ];
    for arguments in commands {
        interrupt(folder.path(), arguments, after);
    }
    for whole in ["imported.mcap", "check.json", "exported"] {
        assert!(!folder.path().join(whole).exists(), "{whole}");
    }
}

/// What an interrupted study has is kept beside the results of an earlier, whole one.
#[test]
fn an_interrupted_study_keeps_earlier_results() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("delay.json"), "whole").unwrap();
    let command = "study delay --runs 2000 --json delay.json --force";
    let arguments: Vec<&str> = command.split(' ').collect();
    interrupt(folder.path(), &arguments, Duration::from_millis(1500));
    let kept = std::fs::read_to_string(folder.path().join("delay.json")).unwrap();
    assert_eq!(kept, "whole");
    assert!(folder.path().join("delay.interrupted.json").exists());
}
