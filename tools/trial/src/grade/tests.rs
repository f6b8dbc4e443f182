//! Answers to one label and their grades.

use super::grader::{grade, no_answer};
use super::score::{AnswerFlag, CaseScore, TrialGrade};
use crate::answer;
use crate::label::{DiagnosisVerdict, Label};

fn label() -> Label {
    let text = r#"
            verdict = "explained"
            robot_toml = "r.toml"
            [[effects]]
            effect = "floor_slope"
            robot = "r1"
            parameters = { grade = 0.01, downhill_rad = 3.0 }
            channels = ["longitudinal", "yaw"]
            intervals_s = [[1.0, 2.0]]
            deviations = { grade = 0.0001 }
        "#;
    toml::from_str(text).unwrap()
}

const RIGHT: &str = r#"{"verdict": "explained", "findings": [{"robot": "r1",
        "effect": "floor_slope", "where": {"channel": "yaw", "intervals_s": [[1.2, 2.1]]},
        "confused_with": [], "parameters": [
        {"name": "grade", "estimate": 0.0104, "ci95": [0.0099, 0.0109]},
        {"name": "downhill_rad", "estimate": -3.4, "ci95": [-3.41, -3.3]}]}],
        "held_out": {"nrmse_before": 4.0, "nrmse_after": 1.0}}"#;

fn graded(text: &str) -> CaseScore {
    grade(&label(), &answer::parse(text).unwrap())
}

#[test]
fn a_right_answer_is_exact() {
    let score = graded(&RIGHT.replace("-3.4,", "-3.3,"));
    assert_eq!(score.grade, TrialGrade::Exact, "{:?}", score.remarks);
    assert_eq!(score.held_out, Some([4.0, 1.0]));
    let grade = score.parameters.iter().find(|p| p.name == "grade").unwrap();
    assert_eq!(grade.covered, Some(true));
    assert!((grade.error_in_least_deviations.unwrap() - 4.0).abs() < 1e-9);
}

#[test]
fn each_error_makes_an_answer_inexact() {
    let faults = [
        ("\"yaw\"", "\"lateral\"", "channel lateral"),
        ("[[1.2, 2.1]]", "[[1.6, 3.1]]", "intervals overlap"),
        (
            "0.0104, \"ci95\": [0.0099",
            "0.0108, \"ci95\": [0.0107",
            "grade 0.0108",
        ),
        ("\"explained\"", "\"unexplained\"", "verdict unexplained"),
        (
            "\"downhill_rad\"",
            "\"downhill\"",
            "downhill_rad is not given",
        ),
    ];
    for (from, to, remark) in faults {
        let score = graded(&RIGHT.replace("-3.4,", "-3.3,").replacen(from, to, 1));
        assert_eq!(score.grade, TrialGrade::Inexact, "{to}");
        assert!(
            score.remarks.iter().any(|r| r.contains(remark)),
            "{:?}",
            score.remarks
        );
    }
}

#[test]
fn wrong_and_missing_effects_are_distinguished() {
    let other = RIGHT.replace("floor_slope", "payload");
    assert_eq!(graded(&other).grade, TrialGrade::Wrong);
    let twins = other.replace(
        "\"confused_with\": []",
        "\"confused_with\": [\"floor_slope\"]",
    );
    assert_eq!(graded(&twins).grade, TrialGrade::LookAlike);
    assert_eq!(
        graded(&RIGHT.replace("\"r1\"", "\"r2\"")).grade,
        TrialGrade::Wrong
    );
    let flag = RIGHT.replace("floor_slope", "unknown");
    assert_eq!(graded(&flag).grade, TrialGrade::Flagged);
    assert_eq!(graded("{\"verdict\": \"match\"}").grade, TrialGrade::Missed);
}

#[test]
fn a_case_without_effects_is_exact_or_a_false_alarm() {
    let mut label = label();
    label.effects.clear();
    label.verdict = DiagnosisVerdict::Match;
    let graded = |text: &str| grade(&label, &answer::parse(text).unwrap()).grade;
    assert_eq!(graded("{\"verdict\": \"match\"}"), TrialGrade::Exact);
    assert_eq!(
        graded("{\"verdict\": \"unexplained\"}"),
        TrialGrade::FalseAlarm
    );
    assert_eq!(graded(RIGHT), TrialGrade::FalseAlarm);
}

#[test]
fn an_unknown_effect_needs_its_driver() {
    let label: Label = toml::from_str(
        r#"
            verdict = "unexplained"
            robot_toml = "r.toml"
            [unknown]
            robot = "r1"
            kind = "carpet"
            channels = ["longitudinal"]
            driver = ["x", "position"]
            "#,
    )
    .unwrap();
    let text = r#"{"verdict": "unexplained", "findings": [{"robot": "r1", "effect": "unknown",
            "where": {"channel": "longitudinal"}, "driver": "x"}]}"#;
    let graded = |text: &str| grade(&label, &answer::parse(text).unwrap()).grade;
    assert_eq!(graded(text), TrialGrade::Exact);
    assert_eq!(graded(&text.replace("\"x\"", "\"t\"")), TrialGrade::Inexact);
    assert_eq!(
        graded(&text.replace("\"unknown\"", "\"push\"")),
        TrialGrade::Wrong
    );
}

/// A latency that differs by run, and a nuisance that excuses a lag.
fn of_runs() -> Label {
    let effect = |run: &str, latency_s: f64| {
        format!(
            "[[effects]]\neffect = \"pose_latency\"\nrobot = \"r1\"\nruns = [\"{run}\"]\nchannels = [\"sensor_pose\"]\n\
             parameters = {{ latency_s = {latency_s} }}\ntolerances = {{ latency_s = 0.005 }}\n"
        )
    };
    let head = "verdict = \"explained\"\nrobot_toml = \"r.toml\"\nnuisances = [\"slow_drive\"]\nallowed = [\"actuator_lag\"]\n";
    toml::from_str(&[head, &effect("r1", 0.1), &effect("r2", 0.2)].concat()).unwrap()
}

fn late(robot: &str, runs: &str, latency_s: f64) -> String {
    format!(
        r#"{{"robot": "{robot}", "effect": "pose_latency", "where": {{"channel": "sensor_pose"}}{runs},
            "parameters": [{{"name": "latency_s", "estimate": {latency_s}, "ci95": [{latency_s}, {latency_s}]}}]}}"#
    )
}

fn graded_by_run(findings: &[String]) -> CaseScore {
    let text = format!(
        r#"{{"verdict": "explained", "findings": [{}]}}"#,
        findings.join(", ")
    );
    grade(&of_runs(), &answer::parse(&text).unwrap())
}

#[test]
fn effects_of_single_runs_are_matched_by_run() {
    let [one, two] = ["r1", "r2"].map(|run| format!(r#", "runs": ["{run}"]"#));
    let right = [late("r1", &one, 0.1), late("r2", &two, 0.204)];
    let score = graded_by_run(&right);
    assert_eq!(score.grade, TrialGrade::Exact, "{:?}", score.remarks);
    let swapped = [late("r1", &one, 0.2), late("r2", &two, 0.1)];
    assert_eq!(graded_by_run(&swapped).grade, TrialGrade::Inexact);
    assert_eq!(graded_by_run(&right[..1]).grade, TrialGrade::Missed);
    // One latency for all runs names the effect, not its sizes.
    let shared = graded_by_run(&[late("r1", "", 0.15)]);
    assert_eq!(
        (shared.grade, shared.remarks.len()),
        (TrialGrade::Inexact, 2)
    );
}

#[test]
fn one_effect_of_the_machine_may_be_found_run_by_run() {
    let mut label = of_runs();
    label.effects.pop();
    label.effects[0].runs.clear();
    let [one, two] = ["r1", "r2"].map(|run| format!(r#", "runs": ["{run}"]"#));
    let graded = |first: f64, second: f64| {
        let findings = [late("r1", &one, first), late("r2", &two, second)].join(", ");
        let text = format!(r#"{{"verdict": "explained", "findings": [{findings}]}}"#);
        grade(&label, &answer::parse(&text).unwrap()).grade
    };
    assert_eq!(graded(0.1, 0.104), TrialGrade::Exact);
    assert_eq!(graded(0.1, 0.15), TrialGrade::Inexact);
}

#[test]
fn what_a_nuisance_brings_is_not_wrong() {
    let lag = r#"{"robot": "r1", "effect": "actuator_lag", "where": {"channel": "yaw"}}"#;
    let both = [late("r1", "", 0.15), lag.to_owned()];
    assert_eq!(graded_by_run(&both).grade, TrialGrade::Inexact);
    let push = [late("r1", "", 0.15), lag.replace("actuator_lag", "push")];
    assert_eq!(graded_by_run(&push).grade, TrialGrade::Wrong);
}

#[test]
fn a_null_with_nuisances_may_be_doubted_but_nothing_named() {
    let mut label = of_runs();
    label.effects.clear();
    label.verdict = DiagnosisVerdict::Match;
    let graded = |label: &Label, text: &str| grade(label, &answer::parse(text).unwrap()).grade;
    let doubted = r#"{"verdict": "unexplained"}"#;
    assert_eq!(graded(&label, doubted), TrialGrade::Inexact);
    label.allowed.push("unknown".to_owned());
    assert_eq!(graded(&label, doubted), TrialGrade::Exact);
    let excused = r#"{"verdict": "explained", "findings": [{"robot": "r1", "effect": "actuator_lag",
        "where": {"channel": "yaw"}}]}"#;
    assert_eq!(graded(&label, excused), TrialGrade::Exact);
    let named = r#"{"verdict": "explained", "findings": [{"robot": "r1", "effect": "push", "where": {"channel": "yaw"}}]}"#;
    assert_eq!(graded(&label, named), TrialGrade::FalseAlarm);
}

#[test]
fn a_refusal_is_a_failure_with_a_flag() {
    let refused = no_answer(&of_runs(), "exit status: 2".to_owned(), true);
    assert_eq!(
        (refused.grade, refused.flags),
        (TrialGrade::Failed, vec![AnswerFlag::Refused])
    );
    assert_eq!(
        no_answer(&of_runs(), "no answer in 300 s".to_owned(), false).flags,
        []
    );
}
