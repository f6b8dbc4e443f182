//! What the commands write, against the schemas that describe it.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at what it does not expect"
)]

mod common;

use std::path::{Path, PathBuf};

use common::{read_json, slipstream};
use serde_json::Value;

fn schema(name: &str) -> jsonschema::Validator {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas");
    let schema = read_json(&folder.join(format!("{name}.schema.json")));
    jsonschema::validator_for(&schema).unwrap()
}

fn faults(name: &str, answer: &Value) -> Vec<String> {
    let schema = schema(name);
    let errors = schema.iter_errors(answer);
    errors
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect()
}

/// Runs a command that writes `answer.json`, and holds that against its schema.
fn holds(folder: &Path, name: &str, arguments: &[&str]) -> Value {
    let arguments = [arguments, &["--json", "answer.json"]].concat();
    let output = slipstream(folder, &arguments);
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {words}");
    let answer = read_json(&folder.join("answer.json"));
    let faults = faults(name, &answer);
    assert!(faults.is_empty(), "{name}: {faults:?}");
    answer
}

fn example(file: &str) -> String {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let path = root.join("tests/example").join(file);
    path.to_string_lossy().into_owned()
}

#[test]
fn runs_and_their_traces() {
    let folder = tempfile::tempdir().unwrap();
    let holds = |name, arguments: &[&str]| holds(folder.path(), name, arguments);
    holds("run", &["run", "--out", "run.mcap"]);
    holds("trace", &["trace", "run.mcap"]);
    holds("trace", &["trace", "run.mcap", "--against", "run.mcap"]);
}

#[test]
fn studies() {
    let folder = tempfile::tempdir().unwrap();
    let study = [
        "study", "delay", "--runs", "1", "--delay", "0,0.1", "--jitter", "0",
    ];
    let more = ["--loss", "0", "--k-x", "1", "--torque-limit", "none"];
    holds(folder.path(), "study", &[&study[..], &more].concat());
}

#[test]
fn the_paper_reproduced() {
    let folder = tempfile::tempdir().unwrap();
    holds(folder.path(), "reproduce", &["reproduce"]);
}

#[test]
fn recordings_and_trials() {
    let folder = tempfile::tempdir().unwrap();
    let holds = |name, arguments: &[&str]| holds(folder.path(), name, arguments);
    let (recording, robot) = (example("recording"), example("robot.toml"));
    holds("check", &["check", &recording]);
    let diagnose = ["diagnose", &*recording, "--robot", &*robot];
    let mut answer = holds("diagnose", &diagnose);
    holds("trial", &["trial", "--cases", "1", "--seed", "3"]);
    // a schema that lets everything pass would hold nothing
    answer["verdict"] = "perhaps".into();
    assert_eq!(faults("diagnose", &answer).len(), 1);
}
