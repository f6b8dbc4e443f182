//! No verdict contradicts its numbers, and every number keeps its invariants: over simulated robots, over the
//! recordings of this repository, and over others where they are.
//!
//! `SLIPSTREAM_LONG=1` diagnoses all of them and prints a table, `SLIPSTREAM_LONG=NAME,NAME` those beside the repository
//! whose names begin so; the short form takes those of the repository and the small ones beside it.

mod contradictions;
mod inputs;
mod invariants;

use std::path::{Path, PathBuf};

use slipstream_bus::RobotModel;
use slipstream_diagnose::{Illustrated, Request, diagnose_with_figures};
use slipstream_recording::Recording;

use contradictions::{contradictions, worse};
use inputs::{Input, inputs};
use invariants::broken;

/// Folders beside the repository, and whether the short form looks into them.
const BESIDE: [(&str, bool); 2] = [("../shared/field", true), ("../shared/recordings", false)];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn all_inputs() -> Vec<Input> {
    let long = std::env::var("SLIPSTREAM_LONG").ok();
    let is_asked = |name: &str| match long.as_deref() {
        Some("1") | None => true,
        Some(names) => names.split(',').any(|own| name.starts_with(own)),
    };
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
        } else if long.is_some() || is_small {
            let own = inputs(&folder).into_iter();
            all.extend(own.filter(|input| is_asked(&input.name)));
        }
    }
    all
}

/// The answer with its figures; the message of a recording that cannot be diagnosed.
fn answer(input: &Input) -> Result<Illustrated, String> {
    let (recording, model) = input.read()?;
    if recording.robots.is_empty() {
        return Err("no robot".to_owned());
    }
    diagnosed(recording, &model)
}

fn diagnosed(recording: Recording, model: &RobotModel) -> Result<Illustrated, String> {
    let request = Request {
        recordings: &[recording],
        against: &[],
        model_of: &|_| Some(model.clone()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    };
    diagnose_with_figures(&request).map_err(|error| error.to_string())
}

/// What the answer contradicts, and what it breaks.
fn faults((answer, _, figures): &Illustrated) -> Vec<String> {
    let mut all = contradictions(answer);
    all.extend(broken(answer, figures));
    all
}

/// Robots with masses, of which every truth is known: nothing lacks, and one effect of each kind of parameter.
#[test]
fn answers_about_simulated_robots_keep_every_invariant() {
    let nominal = RobotModel::default();
    for (effect, parameter, size) in [
        ("nothing", "", 0.0),
        ("rolling_resistance", "coefficient", 0.008),
        ("actuator_delay", "delay_s", 0.03),
        ("pose_latency", "latency_s", 0.05),
        ("track_width", "scale", 1.05),
    ] {
        let truth = match effect {
            "nothing" => nominal.clone(),
            _ => nominal.clone().with(effect, &[(parameter, size)]),
        };
        let recording = slipstream_testkit::record(&truth, slipstream_testkit::gentle, 12.0, 3);
        let answer = diagnosed(recording, &nominal);
        let faults = answer.map_or_else(|message| vec![message], |own| faults(&own));
        assert!(faults.is_empty(), "{effect}: {}", faults.join("\n"));
    }
}

#[test]
fn no_verdict_contradicts_its_numbers() {
    let mut all = Vec::new();
    for input in all_inputs() {
        match answer(&input) {
            Err(message) => println!("{:36} no answer: {message}", input.name),
            Ok(illustrated) => {
                let own = faults(&illustrated);
                let answer = illustrated.0;
                let worse = worse(&answer);
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
