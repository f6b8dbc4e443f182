//! Answers to one label and their grades.

use super::grader::grade;
use super::score::{CaseScore, TrialGrade};
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
