//! `slipstream trial` as a command: sealed before, opened after, the same again from the same seed.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at what it does not expect"
)]

mod common;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use common::{command, read_json, slipstream};
use sha2::{Digest, Sha256};

/// Every file of a folder with its bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut rooms = vec![folder.to_owned()];
    while let Some(room) = rooms.pop() {
        for entry in std::fs::read_dir(&room).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                rooms.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    files
}

fn refuse(folder: &Path, arguments: &[&str], wanted: &str) {
    let output = slipstream(folder, &[&["trial"], arguments].concat());
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {words}");
    assert!(
        words.contains(wanted),
        "{arguments:?}: no {wanted:?} in {words}"
    );
}

#[test]
fn the_same_seed_makes_the_same_bytes_and_keeps_its_word() {
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
    assert!(one == two, "the same seed made other bytes");
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
    refuse(
        folder.path(),
        &["--cases", "1", "--make-only", "--out", "one"],
        "one: the folder is not empty; name a new one",
    );
}

/// One case from beginning to end, and again by its labels.
#[test]
fn a_trial_is_held_and_scored() {
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

#[test]
fn what_cannot_be_used_is_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let labels = "[a]\nverdict = \"perhaps\"\nrobot_toml = \"a.toml\"\n";
    std::fs::write(folder.path().join("labels.toml"), labels).unwrap();
    refuse(
        folder.path(),
        &["--labels", "labels.toml"],
        "labels.toml:2: ",
    );
    let labels = "[a]\nverdict = \"match\"\nrobot_toml = \"a.toml\"\n";
    std::fs::write(folder.path().join("labels.toml"), labels).unwrap();
    refuse(
        folder.path(),
        &["--labels", "labels.toml"],
        "labels stand beside the folders",
    );
    refuse(
        folder.path(),
        &["--labels", "labels.toml", "--only", "b"],
        "--only b: is no case of",
    );
    refuse(
        folder.path(),
        &["--labels", "nowhere.toml"],
        "nowhere.toml: ",
    );
    refuse(
        folder.path(),
        &["--without", "gravity"],
        "--without gravity: is no effect",
    );
}

/// Interrupted while cases are made: exit code 130, and no folder.
#[test]
fn an_interruption_leaves_nothing() {
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
