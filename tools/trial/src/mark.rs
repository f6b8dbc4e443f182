//! One answer against one label.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::answer::{Answer, Finding, Parameter};
use crate::intervals::overlap;
use crate::label::{Hidden, Label, Unknown, Value, Verdict};

/// Half the width of a 95 % interval, in deviations.
const DEVIATIONS_95: f64 = 1.96;
/// A parameter this near to the truth, in proportion, is right whatever its interval says.
const NEAR: f64 = 0.05;
/// Intervals that overlap by so much (intersection over union) are right.
const OVERLAP: f64 = 0.5;

/// What an answer was.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Verdict, effects, robots, channels, intervals and parameters all right.
    Exact,
    /// Effects and robots right, something else not.
    Inexact,
    /// Not the effect itself, but one declared to be inseparable from it.
    LookAlike,
    /// Said that something of an unknown kind is there, where the vocabulary has it.
    Flagged,
    /// Not found, and nothing wrong said.
    Missed,
    /// Named what is not there.
    Wrong,
    /// Named, or flagged, something where nothing is.
    FalseAlarm,
    /// No answer: an error, or out of time.
    Failed,
}

impl Outcome {
    /// All of them, best first.
    pub const ALL: [Self; 8] = [
        Self::Exact,
        Self::Inexact,
        Self::LookAlike,
        Self::Flagged,
        Self::Missed,
        Self::Wrong,
        Self::FalseAlarm,
        Self::Failed,
    ];

    /// Its name in answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Inexact => "inexact",
            Self::LookAlike => "look_alike",
            Self::Flagged => "flagged",
            Self::Missed => "missed",
            Self::Wrong => "wrong",
            Self::FalseAlarm => "false_alarm",
            Self::Failed => "failed",
        }
    }
}

/// How one case went.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mark {
    /// What the answer was.
    pub outcome: Outcome,
    /// Each pair of what is there and what was named for it; `none` for nothing.
    pub pairs: Vec<[String; 2]>,
    /// What kept it from being exact.
    pub remarks: Vec<String>,
    /// The parameters of the effects that were named right.
    pub parameters: Vec<ParameterMark>,
    /// Prediction error over 5 s on held-out data, before and after, in noise deviations.
    pub held_out: Option<[f64; 2]>,
}

/// One estimated parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterMark {
    /// Of which effect.
    pub effect: String,
    /// Its name.
    pub name: String,
    /// What it is.
    pub truth: f64,
    /// What was said.
    pub estimate: f64,
    /// Whether the 95 % interval holds the truth; null without an interval.
    pub covered: Option<bool>,
    /// Error in deviations that the answer itself states; null without an interval.
    pub error_in_stated_deviations: Option<f64>,
    /// Error in the smallest deviations possible, where the label has them.
    pub error_in_least_deviations: Option<f64>,
}

/// No answer came.
pub fn failed(label: &Label, why: String) -> Mark {
    let truths = truths(label);
    Mark {
        outcome: Outcome::Failed,
        pairs: truths
            .into_iter()
            .map(|truth| [truth, "failed".to_owned()])
            .collect(),
        remarks: vec![why],
        parameters: Vec::new(),
        held_out: None,
    }
}

/// Judges an answer.
pub fn mark(label: &Label, answer: &Answer) -> Mark {
    let mut judge = Judge {
        left: answer.findings.iter().collect(),
        pairs: Vec::new(),
        remarks: Vec::new(),
        parameters: Vec::new(),
        look_alikes: 0,
        missed: 0,
    };
    for hidden in &label.effects {
        judge.named(hidden);
    }
    if let Some(unknown) = &label.unknown {
        judge.unknown(unknown);
    }
    if answer.verdict != label.verdict {
        let said = format!("verdict {:?}, not {:?}", answer.verdict, label.verdict);
        judge.remarks.push(said.to_lowercase());
    }
    let outcome = judge.outcome(label, answer);
    let held_out = answer
        .held_out
        .and_then(|held| Some([held.nrmse_before?, held.nrmse_after?]));
    Mark {
        outcome,
        pairs: judge.pairs,
        remarks: judge.remarks,
        parameters: judge.parameters,
        held_out,
    }
}

fn truths(label: &Label) -> Vec<String> {
    let mut truths: Vec<String> = label
        .effects
        .iter()
        .map(|hidden| hidden.effect.clone())
        .collect();
    truths.extend(label.unknown.iter().map(|_| "unknown".to_owned()));
    if truths.is_empty() {
        truths.push("none".to_owned());
    }
    truths
}

struct Judge<'a> {
    /// Findings that belong to nothing yet.
    left: Vec<&'a Finding>,
    pairs: Vec<[String; 2]>,
    remarks: Vec<String>,
    parameters: Vec<ParameterMark>,
    look_alikes: usize,
    missed: usize,
}

impl<'a> Judge<'a> {
    /// Takes the finding that fits best, if any does.
    fn take(&mut self, fits: impl Fn(&Finding) -> Option<f64>) -> Option<&'a Finding> {
        let scored = self.left.iter().enumerate();
        let scored = scored.filter_map(|(at, finding)| Some((at, fits(finding)?)));
        let best = scored.min_by(|one, other| one.1.total_cmp(&other.1))?;
        Some(self.left.remove(best.0))
    }

    fn named(&mut self, hidden: &Hidden) {
        let own = |finding: &Finding| {
            let right = finding.robot == hidden.robot && finding.effect == hidden.effect;
            right.then(|| distance(hidden, finding))
        };
        if let Some(finding) = self.take(own) {
            self.pairs
                .push([hidden.effect.clone(), finding.effect.clone()]);
            self.place(&hidden.channels, &hidden.intervals_s, finding);
            self.values(hidden, finding);
            return;
        }
        let twin = |finding: &Finding| {
            let known = hidden.confusions.contains(&finding.effect);
            let told = finding.confused_with.contains(&hidden.effect);
            (finding.robot == hidden.robot && (known || told)).then_some(0.0)
        };
        if let Some(finding) = self.take(twin) {
            self.look_alikes += 1;
            self.pairs
                .push([hidden.effect.clone(), finding.effect.clone()]);
            self.remarks.push(format!(
                "{} for its look-alike {}",
                finding.effect, hidden.effect
            ));
            return;
        }
        self.missed += 1;
        self.remarks
            .push(format!("{} of {} not found", hidden.effect, hidden.robot));
        self.pairs.push([hidden.effect.clone(), "none".to_owned()]);
    }

    fn unknown(&mut self, unknown: &Unknown) {
        let own = |finding: &Finding| {
            let right = finding.robot == unknown.robot && finding.effect == "unknown";
            let driver = finding
                .driver
                .as_ref()
                .is_some_and(|name| unknown.driver.contains(name));
            right.then_some(if driver { 0.0 } else { 1.0 })
        };
        let Some(finding) = self.take(own) else {
            self.missed += 1;
            self.remarks.push(format!(
                "unknown {} of {} not found",
                unknown.kind, unknown.robot
            ));
            self.pairs.push(["unknown".to_owned(), "none".to_owned()]);
            return;
        };
        self.pairs
            .push(["unknown".to_owned(), "unknown".to_owned()]);
        self.place(&unknown.channels, &unknown.intervals_s, finding);
        let driver = finding.driver.clone().unwrap_or_default();
        if !unknown.driver.contains(&driver) {
            self.remarks.push(format!(
                "driver {driver:?}, not {}",
                unknown.driver.join(" or ")
            ));
        }
    }

    fn place(&mut self, channels: &[String], intervals_s: &[[f64; 2]], finding: &Finding) {
        let channel = &finding.place.channel;
        if !channels.contains(channel) {
            self.remarks
                .push(format!("channel {channel}, not {}", channels.join(" or ")));
        }
        let overlap = overlap(intervals_s, &finding.place.intervals_s);
        if !intervals_s.is_empty() && overlap < OVERLAP {
            self.remarks.push(format!(
                "{}: intervals overlap by {overlap:.2}",
                finding.effect
            ));
        }
    }

    fn values(&mut self, hidden: &Hidden, finding: &Finding) {
        for (name, truth) in &hidden.parameters {
            let Some(said) = finding.parameters.iter().find(|said| said.name == *name) else {
                self.remarks
                    .push(format!("{}.{name} is not given", hidden.effect));
                continue;
            };
            match truth {
                Value::Text(text) if said.text.as_ref() == Some(text) => {}
                Value::Text(text) => {
                    self.remarks
                        .push(format!("{}.{name} is not {text}", hidden.effect));
                }
                Value::Number(truth) => self.number(hidden, *truth, said),
            }
        }
    }

    fn number(&mut self, hidden: &Hidden, truth: f64, said: &Parameter) {
        let Some(estimate) = said.estimate else {
            self.remarks
                .push(format!("{}.{} has no estimate", hidden.effect, said.name));
            return;
        };
        // the whole turn that brings the estimate nearest to the truth, for directions
        let turn = nearest_turn(&said.name, truth, estimate);
        let error = estimate + turn - truth;
        let interval = said.interval();
        let covered = interval.map(|[low, high]| low <= truth - turn && truth - turn <= high);
        if covered != Some(true) && error.abs() > NEAR * truth.abs() {
            let words = format!(
                "{}.{} {estimate:.6}, not {truth:.6}",
                hidden.effect, said.name
            );
            self.remarks.push(words);
        }
        let stated = interval.map(|[low, high]| (high - low) / (2.0 * DEVIATIONS_95));
        let least = hidden.deviations.get(&said.name).copied();
        let ratio = |deviation: f64| (deviation > 0.0).then(|| error / deviation);
        self.parameters.push(ParameterMark {
            effect: hidden.effect.clone(),
            name: said.name.clone(),
            truth,
            estimate,
            covered,
            error_in_stated_deviations: stated.and_then(ratio),
            error_in_least_deviations: least.and_then(ratio),
        });
    }

    /// What the answer comes to; what is left belongs to nothing that is there.
    fn outcome(&mut self, label: &Label, answer: &Answer) -> Outcome {
        let nothing = label.effects.is_empty() && label.unknown.is_none();
        let flags = self
            .left
            .iter()
            .filter(|finding| finding.effect == "unknown")
            .count();
        let wrong = self.left.len() - flags;
        for finding in std::mem::take(&mut self.left) {
            let Finding { effect, robot, .. } = finding;
            self.remarks
                .push(format!("{effect} of {robot} is not there"));
            self.pairs.push(["none".to_owned(), effect.clone()]);
        }
        if nothing && self.pairs.is_empty() {
            self.pairs.push(["none".to_owned(), "none".to_owned()]);
        }
        match () {
            () if nothing && (wrong + flags > 0 || answer.verdict != Verdict::Match) => {
                Outcome::FalseAlarm
            }
            () if wrong > 0 => Outcome::Wrong,
            () if self.missed > 0 && flags > 0 => Outcome::Flagged,
            () if self.missed > 0 => Outcome::Missed,
            () if self.look_alikes > 0 => Outcome::LookAlike,
            () if self.remarks.is_empty() => Outcome::Exact,
            () => Outcome::Inexact,
        }
    }
}

/// How far a finding's numbers are from the truth, for effects that occur more than once.
fn distance(hidden: &Hidden, finding: &Finding) -> f64 {
    let said: BTreeMap<&str, &Parameter> = finding
        .parameters
        .iter()
        .map(|said| (said.name.as_str(), said))
        .collect();
    let part = |(name, truth): (&String, &Value)| match (truth, said.get(name.as_str())) {
        (Value::Number(truth), Some(said)) => said
            .estimate
            .map_or(1.0, |estimate| (estimate - truth).abs()),
        (Value::Text(text), Some(said)) if said.text.as_ref() == Some(text) => 0.0,
        _ => 1e3,
    };
    hidden.parameters.iter().map(part).sum()
}

fn nearest_turn(name: &str, truth: f64, estimate: f64) -> f64 {
    let turns = matches!(name, "direction_rad" | "downhill_rad" | "yaw_rad");
    if turns {
        ((truth - estimate) / std::f64::consts::TAU).round() * std::f64::consts::TAU
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer;

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

    fn judged(text: &str) -> Mark {
        mark(&label(), &answer::parse(text).unwrap())
    }

    #[test]
    fn a_right_answer_is_exact() {
        let mark = judged(&RIGHT.replace("-3.4,", "-3.3,"));
        assert_eq!(mark.outcome, Outcome::Exact, "{:?}", mark.remarks);
        assert_eq!(mark.held_out, Some([4.0, 1.0]));
        let grade = mark.parameters.iter().find(|p| p.name == "grade").unwrap();
        assert_eq!(grade.covered, Some(true));
        assert!((grade.error_in_least_deviations.unwrap() - 4.0).abs() < 1e-9);
    }

    #[test]
    fn each_fault_costs_exactness() {
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
            let mark = judged(&RIGHT.replace("-3.4,", "-3.3,").replacen(from, to, 1));
            assert_eq!(mark.outcome, Outcome::Inexact, "{to}");
            assert!(
                mark.remarks.iter().any(|r| r.contains(remark)),
                "{:?}",
                mark.remarks
            );
        }
    }

    #[test]
    fn other_names_are_told_apart() {
        let other = RIGHT.replace("floor_slope", "payload");
        assert_eq!(judged(&other).outcome, Outcome::Wrong);
        let twins = other.replace(
            "\"confused_with\": []",
            "\"confused_with\": [\"floor_slope\"]",
        );
        assert_eq!(judged(&twins).outcome, Outcome::LookAlike);
        assert_eq!(
            judged(&RIGHT.replace("\"r1\"", "\"r2\"")).outcome,
            Outcome::Wrong
        );
        let flag = RIGHT.replace("floor_slope", "unknown");
        assert_eq!(judged(&flag).outcome, Outcome::Flagged);
        assert_eq!(judged("{\"verdict\": \"match\"}").outcome, Outcome::Missed);
    }

    #[test]
    fn nothing_there_is_either_matched_or_a_false_alarm() {
        let mut label = label();
        label.effects.clear();
        label.verdict = Verdict::Match;
        let judge = |text: &str| mark(&label, &answer::parse(text).unwrap()).outcome;
        assert_eq!(judge("{\"verdict\": \"match\"}"), Outcome::Exact);
        assert_eq!(judge("{\"verdict\": \"unexplained\"}"), Outcome::FalseAlarm);
        assert_eq!(judge(RIGHT), Outcome::FalseAlarm);
    }

    #[test]
    fn an_unknown_needs_its_driver() {
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
        let judge = |text: &str| mark(&label, &answer::parse(text).unwrap()).outcome;
        assert_eq!(judge(text), Outcome::Exact);
        assert_eq!(judge(&text.replace("\"x\"", "\"t\"")), Outcome::Inexact);
        assert_eq!(
            judge(&text.replace("\"unknown\"", "\"push\"")),
            Outcome::Wrong
        );
    }
}
