//! `slipstream trial` on the command line: commitments, reproducible seeds, scores, interruption.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::collections::BTreeMap;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use common::{command, read_json, slipstream};
use sha2::{Digest, Sha256};

/// All files below a folder, by relative path.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    files
}

/// Expects exit code 2 and an error that contains `expected`.
fn assert_refused(folder: &Path, arguments: &[&str], expected: &str) {
    let output = slipstream(folder, &[&["trial"], arguments].concat());
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert!(
        stderr.contains(expected),
        "{arguments:?}: no {expected:?} in {stderr}"
    );
}

#[test]
fn a_seed_gives_the_same_files_and_commitments_match_the_labels() {
    let folder = tempfile::tempdir().unwrap();
    for out in ["one", "two"] {
        let output = slipstream(
            folder.path(),
            &[
                "trial",
                "--cases",
                "3",
                "--seed",
                "5",
                "--make-only",
                "--out",
                out,
            ],
        );
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let (one, two) = (
        files(&folder.path().join("one")),
        files(&folder.path().join("two")),
    );
    assert!(one == two, "the same seed made different files");
    let commitments = String::from_utf8(one["commitments.txt"].clone()).unwrap();
    assert_eq!(commitments.lines().count(), 3);
    for line in commitments.lines() {
        let (digits, name) = line.split_once("  ").unwrap();
        let sealed = &one[&format!("sealed/{name}.txt")];
        let hash: String = Sha256::digest(sealed)
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        assert_eq!(digits, hash, "{name}");
        assert!(one.contains_key(&format!("robots/{name}.toml")));
        assert!(one.contains_key(&format!("{name}/recording.toml")));
    }
    assert_refused(
        folder.path(),
        &["--cases", "1", "--make-only", "--out", "one"],
        "one: the folder is not empty; give a new folder",
    );
}

/// One new case from start to end, then the same case again from its labels.
#[test]
fn a_trial_and_its_repetition_from_labels_have_the_same_scores() {
    let folder = tempfile::tempdir().unwrap();
    let held = ["trial", "--cases", "1", "--seed", "9", "--limit-s", "120"];
    let output = slipstream(
        folder.path(),
        &[&held[..], &["--out", "held", "--json", "held.json"]].concat(),
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let report = read_json(&folder.path().join("held.json"));
    assert_eq!(report["format"], 1);
    assert_eq!(report["cases"], 1);
    let published =
        std::fs::read_to_string(folder.path().join("held").join("commitments.txt")).unwrap();
    let commitment = report["commitments"][0].as_str().unwrap();
    assert!(published.starts_with(commitment));
    let again = [
        "trial",
        "--labels",
        "held/labels.toml",
        "--json",
        "again.json",
    ];
    assert!(slipstream(folder.path(), &again).status.success());
    let again = read_json(&folder.path().join("again.json"));
    for key in [
        "exact",
        "inexact",
        "missed",
        "wrong",
        "false_alarms",
        "failed",
        "confusion",
    ] {
        assert_eq!(report[key], again[key], "{key}");
    }
}

/// Writes a shell script with the arguments of `slipstream diagnose` that runs `answer`, and a case without
/// effects.
fn write_program(folder: &Path, answer: &str) {
    let script = format!("#!/bin/sh\n[ \"$5\" = --json ] || exit 3\n{answer}\n");
    let path = folder.join("program");
    std::fs::write(&path, script).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    let folder = folder.join("case");
    if !folder.exists() {
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("recording.toml"), "format = 1\n").unwrap();
    }
    std::fs::write(folder.with_file_name("robot.toml"), "format = 1\n").unwrap();
    let labels = "[case]\nverdict = \"match\"\nrobot_toml = \"robot.toml\"\n";
    std::fs::write(folder.with_file_name("labels.toml"), labels).unwrap();
}

const WITH: [&str; 7] = [
    "trial",
    "--labels",
    "labels.toml",
    "--with",
    "program",
    "--json",
    "trial.json",
];

#[test]
fn answers_of_another_program_are_scored() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = |answer: &str, limit: &str| {
        write_program(folder.path(), answer);
        let output = slipstream(folder.path(), &[&WITH[..], &["--limit-s", limit]].concat());
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        read_json(&folder.path().join("trial.json"))["each"][0].clone()
    };
    let exact = outcome("echo '{\"verdict\": \"match\"}' > \"$6\"", "60");
    assert_eq!(exact["outcome"], "exact");
    let alarm = outcome("echo '{\"verdict\": \"unexplained\"}' > \"$6\"", "60");
    assert_eq!(alarm["outcome"], "false_alarm");
    let failed = outcome("echo 'no idea' >&2; exit 1", "60");
    assert_eq!(failed["outcome"], "failed");
    assert!(failed["remarks"][0].as_str().unwrap().contains("no idea"));
    let slow = outcome("exec sleep 60", "1");
    assert_eq!(slow["remarks"][0], "no answer in 1 s");
    // The program sees the recording and the model, but no label.
    let isolated = outcome(
        "[ \"$(ls)\" = \"recording\nrobot.toml\nwords.txt\" ] || { ls >&2; exit 1; }\necho '{\"verdict\": \"match\"}' > \"$6\"",
        "60",
    );
    assert_eq!(isolated["outcome"], "exact", "{isolated}");
}

#[test]
fn an_interrupted_diagnosis_leaves_no_scores() {
    let folder = tempfile::tempdir().unwrap();
    write_program(folder.path(), "exec sleep 60");
    let mut child = command(folder.path(), &WITH).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(500));
    let interrupt = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(interrupt.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!folder.path().join("trial.json").exists());
}

#[test]
fn invalid_input_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let labels = "[a]\nverdict = \"perhaps\"\nrobot_toml = \"a.toml\"\n";
    std::fs::write(folder.path().join("labels.toml"), labels).unwrap();
    assert_refused(
        folder.path(),
        &["--labels", "labels.toml"],
        "labels.toml:2: ",
    );
    let labels = "[a]\nverdict = \"match\"\nrobot_toml = \"a.toml\"\n";
    std::fs::write(folder.path().join("labels.toml"), labels).unwrap();
    assert_refused(
        folder.path(),
        &["--labels", "labels.toml"],
        "labels stand beside the folders",
    );
    assert_refused(
        folder.path(),
        &["--labels", "labels.toml", "--only", "b"],
        "--only b: is no case of",
    );
    assert_refused(
        folder.path(),
        &["--labels", "nowhere.toml"],
        "nowhere.toml: ",
    );
    assert_refused(
        folder.path(),
        &["--without", "gravity"],
        "--without gravity: is not an effect",
    );
}

/// An interruption while cases are made: exit code 130, and no folder.
#[test]
fn an_interruption_while_making_cases_leaves_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["trial", "--cases", "500", "--make-only", "--out", "never"];
    let mut child = command(folder.path(), &arguments).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(500));
    let interrupt = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(interrupt.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}
