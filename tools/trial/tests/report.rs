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
nuisances = ["held_rows", "jitter"]
"#;

const ANSWER: &str = r#"{"verdict": "explained", "findings": [{"robot": "r1",
    "effect": "floor_slope", "where": {"channel": "yaw", "intervals_s": [[1.1, 2.4]]},
    "parameters": [{"name": "grade", "estimate": 0.0041, "ci95": [0.0039, 0.00431]},
                   {"name": "downhill_rad", "estimate": 0.91}]}],
    "held_out": {"nrmse_before": 4.1, "nrmse_after": 1.03},
    "budget": [{"robot": "r1", "unit": "m", "before": 0.1, "after": 0.11}]}"#;

#[test]
fn a_report_is_read_back_from_its_json() {
    let labels = label::parse(LABELS, Path::new("labels.toml")).unwrap();
    let answers = [
        answer::parse(ANSWER),
        answer::parse(r#"{"verdict": "match"}"#),
        Err("exit status: 2: r1 has no rows".to_owned()),
    ];
    let runs = answers.into_iter().map(|answer| DiagnosisRun {
        refused: answer.is_err(),
        answer,
        seconds: 1.7,
    });
    let scores = score(&labels, &questions(&labels, &[]), runs.collect());
    let mut report = tally(scores, vec!["0f".to_owned()], None);
    assert_eq!(report.seconds, Some([1.7, 1.7]));
    // What depends on the machine is not in the JSON.
    report.seconds = None;
    report.each.iter_mut().for_each(|own| own.seconds = None);
    assert_eq!((report.cases, report.exact, report.failed), (3, 1, 1));
    assert_eq!(
        (report.refused, report.contradictions, report.worse),
        (1, 0, 1)
    );
    let counts = |name: &str| {
        let own = &report.nuisances[name];
        [
            own.cases,
            own.right,
            own.missed,
            own.failed,
            own.refused,
            own.worse,
        ]
    };
    assert_eq!(counts("none"), [2, 1, 1, 0, 0, 1]);
    assert_eq!(counts("held_rows"), [1, 0, 0, 1, 1, 0]);
    assert_eq!(report.nuisances.len(), 3);
    let text = serde_json::to_string_pretty(&report).unwrap();
    let again: TrialReport = serde_json::from_str(&text).unwrap();
    assert_eq!(again, report);
    assert_eq!(serde_json::to_string_pretty(&again).unwrap(), text);
}

#[test]
fn a_right_answer_to_nothing_is_no_concealed_effect_that_was_found() {
    let labels = label::parse(LABELS, Path::new("labels.toml")).unwrap();
    let runs = (0..3).map(|_| DiagnosisRun {
        refused: false,
        answer: answer::parse(r#"{"verdict": "match"}"#),
        seconds: 1.0,
    });
    let scores = score(&labels, &questions(&labels, &[]), runs.collect());
    let report = tally(scores, Vec::new(), None);
    assert_eq!((report.nulls, report.exact, report.missed), (1, 1, 2));
    assert_eq!(report.concealed(), [2, 0]);
}
