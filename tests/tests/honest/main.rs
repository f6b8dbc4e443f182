//! No verdict contradicts its numbers: over the recordings of this repository, and over others where they are.
//!
//! `SLIPSTREAM_LONG=1` diagnoses all of them and prints a table; the short form takes those of the repository and the
//! small ones beside it.

mod contradictions;
mod inputs;

use std::path::{Path, PathBuf};

use slipstream_answer::Answer;
use slipstream_diagnose::{Request, diagnose};

use contradictions::{contradictions, worse};
use inputs::{Input, inputs};

/// Folders beside the repository, and whether the short form looks into them.
const BESIDE: [(&str, bool); 2] = [("../shared/field", true), ("../shared/recordings", false)];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn all_inputs() -> Vec<Input> {
    let long = std::env::var_os("SLIPSTREAM_LONG").is_some();
    let mut all = vec![Input {
        name: "example".to_owned(),
        recording: root().join("tests/example/recording"),
        columns: None,
        robot: root().join("tests/example/robot.toml"),
    }];
    for (folder, is_small) in BESIDE {
        let folder = root().join(folder);
        if !folder.is_dir() {
            println!("SKIPPED: {} is not there", folder.display());
        } else if long || is_small {
            all.extend(inputs(&folder));
        }
    }
    all
}

/// The answer; the message of a recording that cannot be diagnosed.
fn answer(input: &Input) -> Result<Answer, String> {
    let (recording, model) = input.read()?;
    if recording.robots.is_empty() {
        return Err("no robot".to_owned());
    }
    let request = Request {
        recordings: &[recording],
        against: &[],
        model_of: &|_| Some(model.clone()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    };
    let (answer, _) = diagnose(&request).map_err(|error| error.to_string())?;
    Ok(answer)
}

#[test]
fn no_verdict_contradicts_its_numbers() {
    let mut all = Vec::new();
    for input in all_inputs() {
        match answer(&input) {
            Err(message) => println!("{:36} no answer: {message}", input.name),
            Ok(answer) => {
                let (own, worse) = (contradictions(&answer), worse(&answer));
                let verdict = format!("{:?}", answer.verdict).to_lowercase();
                let held_out = &answer.held_out;
                println!(
                    "{:36} {verdict:11} {:8.2} -> {:8.2} deviations, {} findings; {} contradictions; worse: {}",
                    input.name,
                    held_out.nrmse_before,
                    held_out.nrmse_after,
                    answer.findings.len(),
                    own.len(),
                    worse.join(", "),
                );
                all.extend(
                    own.into_iter()
                        .map(|what| format!("{}: {what}", input.name)),
                );
            }
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}
