//! JSON answers of the commands conform to their schemas.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::{Path, PathBuf};

use common::schemas::violations;
use common::{read_json, slipstream};
use serde_json::Value;

/// Runs a command with `--json` and validates the answer against its schema.
fn assert_valid(folder: &Path, name: &str, arguments: &[&str]) -> Value {
    let arguments = [arguments, &["--json", "answer.json"]].concat();
    let output = slipstream(folder, &arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    let answer = read_json(&folder.join("answer.json"));
    let violations = violations(name, &answer);
    assert!(violations.is_empty(), "{name}: {violations:?}");
    answer
}

fn example(file: &str) -> String {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let path = root.join("tests/example").join(file);
    path.to_string_lossy().into_owned()
}

#[test]
fn run_and_trace_conform() {
    let folder = tempfile::tempdir().unwrap();
    let assert_valid = |name, arguments: &[&str]| assert_valid(folder.path(), name, arguments);
    assert_valid("run", &["run", "--out", "run.mcap"]);
    assert_valid("trace", &["trace", "run.mcap"]);
    assert_valid("trace", &["trace", "run.mcap", "--against", "run.mcap"]);
}

#[test]
fn study_conforms() {
    let folder = tempfile::tempdir().unwrap();
    let study = [
        "study", "delay", "--runs", "1", "--delay", "0,0.1", "--jitter", "0",
    ];
    let more = ["--loss", "0", "--k-x", "1", "--torque-limit", "none"];
    assert_valid(folder.path(), "study", &[&study[..], &more].concat());
    let sweep = [
        "study",
        "sweep",
        "--set",
        "links.delay_s=0,0.1",
        "--robots",
        "2",
    ];
    assert_valid(folder.path(), "sweep", &sweep);
}

#[test]
fn reproduce_conforms() {
    let folder = tempfile::tempdir().unwrap();
    assert_valid(folder.path(), "reproduce", &["reproduce"]);
}

#[test]
fn robot_conforms() {
    let folder = tempfile::tempdir().unwrap();
    let robots = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../recording/tests/robot_file");
    for name in ["turtle.urdf", "terrain.urdf", "complete.urdf"] {
        let file = robots.join(name);
        assert_valid(folder.path(), "robot", &["robot", &file.to_string_lossy()]);
    }
    let robot = example("robot.toml");
    let mut answer = assert_valid(folder.path(), "robot", &["robot", &robot]);
    answer["kind"] = "sdf".into();
    assert_eq!(violations("robot", &answer).len(), 1);
    let mesh = "<robot><link name=\"base_link\"/></robot>";
    std::fs::write(folder.path().join("no_wheels.urdf"), mesh).unwrap();
    let answer = assert_valid(folder.path(), "robot", &["robot", "no_wheels.urdf"]);
    assert_eq!(answer["complete"], false);
}

#[test]
fn check_diagnose_and_trial_conform() {
    let folder = tempfile::tempdir().unwrap();
    let assert_valid = |name, arguments: &[&str]| assert_valid(folder.path(), name, arguments);
    let (recording, robot) = (example("recording"), example("robot.toml"));
    assert_valid("check", &["check", &recording]);
    let diagnose = ["diagnose", &*recording, "--robot", &*robot];
    let mut answer = assert_valid("diagnose", &diagnose);
    assert_valid("trial", &["trial", "--cases", "1", "--seed", "3"]);
    // The schema does not accept everything.
    answer["verdict"] = "perhaps".into();
    assert_eq!(violations("diagnose", &answer).len(), 1);
}
