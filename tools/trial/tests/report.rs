//! The report of a trial is read back from its JSON.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use slipstream_trial::answer;
use slipstream_trial::diagnosis_process::DiagnosisRun;
use slipstream_trial::label;
use slipstream_trial::protocol::{questions, score};
use slipstream_trial::tally::{TrialReport, tally};

const LABELS: &str = r#"
[a]
verdict = "explained"
robot_toml = "robots/a.toml"
kind = "single"
[[a.effects]]
effect = "floor_slope"
robot = "r1"
parameters = { grade = 0.004, downhill_rad = 0.9 }
channels = ["yaw"]
intervals_s = [[1.0, 2.5]]
expected_gain = 1200.0
deviations = { grade = 0.0001 }
[b]
verdict = "unexplained"
robot_toml = "robots/b.toml"
[b.unknown]
robot = "r1"
kind = "cogging"
channels = ["wheel_right"]
driver = ["wheel_angle"]
[c]
verdict = "match"
robot_toml = "robots/c.toml"
kind = "null"
"#;

const ANSWER: &str = r#"{"verdict": "explained", "findings": [{"robot": "r1",
    "effect": "floor_slope", "where": {"channel": "yaw", "intervals_s": [[1.1, 2.4]]},
    "parameters": [{"name": "grade", "estimate": 0.0041, "ci95": [0.0039, 0.00431]},
                   {"name": "downhill_rad", "estimate": 0.91}]}],
    "held_out": {"nrmse_before": 4.1, "nrmse_after": 1.03}}"#;

#[test]
fn a_report_is_read_back_from_its_json() {
    let labels = label::parse(LABELS, Path::new("labels.toml")).unwrap();
    let answers = [
        answer::parse(ANSWER),
        answer::parse(r#"{"verdict": "match"}"#),
        Err("no answer in 300 s".to_owned()),
    ];
    let runs = answers.into_iter().map(|answer| DiagnosisRun {
        answer,
        refused: false,
        seconds: 1.7,
    });
    let scores = score(&labels, &questions(&labels, &[]), runs.collect());
    let mut report = tally(scores, vec!["0f".to_owned()], None);
    assert_eq!(report.seconds, Some([1.7, 1.7]));
    // What depends on the machine is not in the JSON.
    report.seconds = None;
    report.each.iter_mut().for_each(|own| own.seconds = None);
    assert_eq!((report.cases, report.exact, report.failed), (3, 1, 1));
    let text = serde_json::to_string_pretty(&report).unwrap();
    let again: TrialReport = serde_json::from_str(&text).unwrap();
    assert_eq!(again, report);
    assert_eq!(serde_json::to_string_pretty(&again).unwrap(), text);
}
