//! Matches the findings of an answer with the effects of a label.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use slipstream_sim::effects::{Role, find};

use super::flags::flags;
use super::score::{AnswerFlag, CaseScore, ParameterScore, TrialGrade};
use crate::answer::{DiagnosisAnswer, ReportedFinding, ReportedParameter};
use crate::intervals::overlap;
use crate::label::{ConcealedEffect, DiagnosisVerdict, Label, ParameterValue, UnknownPhysics};

/// The 0.975 quantile of the standard normal distribution, rounded to two decimals as in published
/// tables: half the width of a 95 % interval in standard deviations.
const NORMAL_QUANTILE_975: f64 = 1.96;
/// Relative error up to which an estimate is right whatever its interval.
const RELATIVE_TOLERANCE: f64 = 0.05;
/// Intersection over union from which on intervals are right.
const MIN_OVERLAP: f64 = 0.5;

/// The score of a case without an answer; `why` is the remark, `refused` says that the input was called unusable.
pub fn no_answer(label: &Label, why: String, refused: bool) -> CaseScore {
    let truths = truths(label);
    CaseScore {
        grade: TrialGrade::Failed,
        pairs: truths
            .into_iter()
            .map(|truth| [truth, "failed".to_owned()])
            .collect(),
        remarks: vec![why],
        flags: refused.then_some(AnswerFlag::Refused).into_iter().collect(),
        parameters: Vec::new(),
        held_out: None,
    }
}

/// Grades an answer.
pub fn grade(label: &Label, answer: &DiagnosisAnswer) -> CaseScore {
    let mut grader = Grader {
        unmatched: answer.findings.iter().collect(),
        by_run: Vec::new(),
        pairs: Vec::new(),
        remarks: Vec::new(),
        parameters: Vec::new(),
        look_alikes: 0,
        missed: 0,
    };
    for concealed in &label.effects {
        grader.match_effect(concealed);
    }
    if let Some(unknown) = &label.unknown {
        grader.match_unknown(unknown);
    }
    let excused = grader.put_aside(&label.allowed);
    if !is_right_verdict(label, answer.verdict, excused) {
        let reported = format!("verdict {:?}, not {:?}", answer.verdict, label.verdict);
        grader.remarks.push(reported.to_lowercase());
    }
    let grade = grader.grade(label);
    let held_out = answer
        .held_out
        .and_then(|held| Some([held.nrmse_before?, held.nrmse_after?]));
    CaseScore {
        grade,
        pairs: grader.pairs,
        remarks: grader.remarks,
        flags: flags(answer),
        parameters: grader.parameters,
        held_out,
    }
}

/// Whether this is the verdict of a correct diagnosis; `excused`: it named something that a nuisance brings.
fn is_right_verdict(label: &Label, verdict: DiagnosisVerdict, excused: bool) -> bool {
    let may_remain = label.allowed.iter().any(|name| name == "unknown");
    match verdict {
        DiagnosisVerdict::Unexplained if may_remain => true,
        DiagnosisVerdict::Explained if excused && label.verdict == DiagnosisVerdict::Match => true,
        _ => verdict == label.verdict,
    }
}

/// Whether a finding is about the machine and one of the runs of a concealed effect.
fn is_about(finding: &ReportedFinding, concealed: &ConcealedEffect) -> bool {
    // Runs of one machine are robots of the recording; a finding of one may bear its name.
    let is_run = finding.runs.is_some() || concealed.runs.contains(&finding.robot);
    let holds = |runs: &Vec<String>| runs.iter().any(|run| concealed.runs.contains(run));
    let in_a_run = concealed.runs.is_empty() || finding.runs.as_ref().is_none_or(holds);
    (is_run || finding.robot == concealed.robot) && in_a_run
}

/// Names of the true effects; `none` if there are none.
fn truths(label: &Label) -> Vec<String> {
    let mut truths: Vec<String> = label
        .effects
        .iter()
        .map(|concealed| concealed.effect.clone())
        .collect();
    truths.extend(label.unknown.iter().map(|_| "unknown".to_owned()));
    if truths.is_empty() {
        truths.push("none".to_owned());
    }
    truths
}

/// The comparison of an answer with a label, effect by effect.
struct Grader<'a> {
    /// Findings not yet matched.
    unmatched: Vec<&'a ReportedFinding>,
    /// Findings matched with an effect of single runs: they may hold for other runs as well.
    by_run: Vec<&'a ReportedFinding>,
    pairs: Vec<[String; 2]>,
    remarks: Vec<String>,
    parameters: Vec<ParameterScore>,
    /// Number of effects for which a look-alike was reported.
    look_alikes: usize,
    /// Number of effects without a finding.
    missed: usize,
}

impl<'a> Grader<'a> {
    /// Takes the finding with the smallest cost, if any; `cost` is `None` for one that does not match.
    fn take(
        &mut self,
        cost: impl Fn(&ReportedFinding) -> Option<f64>,
    ) -> Option<&'a ReportedFinding> {
        let scored = self.unmatched.iter().enumerate();
        let scored = scored.filter_map(|(at, finding)| Some((at, cost(finding)?)));
        let best = scored.min_by(|one, other| one.1.total_cmp(&other.1))?;
        Some(self.unmatched.remove(best.0))
    }

    /// Takes the finding for a true effect with the smallest cost. One of single runs stays for those of others.
    fn take_for(
        &mut self,
        concealed: &ConcealedEffect,
        cost: impl Fn(&ReportedFinding) -> Option<f64>,
    ) -> Option<&'a ReportedFinding> {
        if concealed.runs.is_empty() {
            return self.take(cost);
        }
        let taken = self.take(&cost);
        self.by_run.extend(taken);
        taken.or_else(|| {
            let earlier = self.by_run.iter().copied();
            let scored = earlier.filter_map(|finding| Some((cost(finding)?, finding)));
            let best = scored.min_by(|one, other| one.0.total_cmp(&other.0));
            best.map(|(_, finding)| finding)
        })
    }

    /// Takes what is neither asked for nor wrong, and returns whether there was any.
    fn put_aside(&mut self, allowed: &[String]) -> bool {
        let before = self.unmatched.len();
        self.unmatched
            .retain(|finding| !allowed.contains(&finding.effect));
        self.unmatched.len() < before
    }

    /// Matches a true effect: with a finding of this effect, else with a look-alike.
    fn match_effect(&mut self, concealed: &ConcealedEffect) {
        let own = |finding: &ReportedFinding| {
            let right = is_about(finding, concealed) && finding.effect == concealed.effect;
            right.then(|| distance(concealed, finding))
        };
        if let Some(finding) = self.take_for(concealed, own) {
            self.pairs
                .push([concealed.effect.clone(), finding.effect.clone()]);
            self.check_location(&concealed.channels, &concealed.intervals_s, finding);
            self.check_parameters(concealed, finding);
            if concealed.runs.is_empty() && finding.runs.is_some() {
                // The same of other runs, each with its own estimate.
                while let Some(other) =
                    self.take(|other| own(other).filter(|_| other.runs.is_some()))
                {
                    self.check_parameters(concealed, other);
                }
            }
            return;
        }
        let look_alike = |finding: &ReportedFinding| {
            let labelled = concealed.confusions.contains(&finding.effect);
            let declared = finding.confused_with.contains(&concealed.effect);
            (is_about(finding, concealed) && (labelled || declared)).then_some(0.0)
        };
        if let Some(finding) = self.take_for(concealed, look_alike) {
            self.pairs
                .push([concealed.effect.clone(), finding.effect.clone()]);
            // One size for all runs is no look-alike of sizes that differ by run.
            let is_by_run = concealed.runs.is_empty() || finding.runs.is_some();
            self.look_alikes += usize::from(is_by_run);
            self.remarks.push(format!(
                "{}{} for its look-alike {}",
                finding.effect,
                if is_by_run { "" } else { " of all runs" },
                concealed.effect
            ));
            return;
        }
        self.missed += 1;
        let of = match concealed.runs.as_slice() {
            [] => concealed.robot.clone(),
            runs => runs.join(", "),
        };
        self.remarks
            .push(format!("{} of {of} not found", concealed.effect));
        self.pairs
            .push([concealed.effect.clone(), "none".to_owned()]);
    }

    /// Matches physics outside the vocabulary: with a finding `unknown`.
    fn match_unknown(&mut self, unknown: &UnknownPhysics) {
        let own = |finding: &ReportedFinding| {
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
        self.check_location(&unknown.channels, &unknown.intervals_s, finding);
        let driver = finding.driver.clone().unwrap_or_default();
        if !unknown.driver.contains(&driver) {
            self.remarks.push(format!(
                "driver {driver:?}, not {}",
                unknown.driver.join(" or ")
            ));
        }
    }

    /// Compares channel and intervals.
    fn check_location(
        &mut self,
        channels: &[String],
        intervals_s: &[[f64; 2]],
        finding: &ReportedFinding,
    ) {
        let channel = &finding.location.channel;
        if !channels.contains(channel) {
            self.remarks
                .push(format!("channel {channel}, not {}", channels.join(" or ")));
        }
        let overlap = overlap(intervals_s, &finding.location.intervals_s);
        if !intervals_s.is_empty() && overlap < MIN_OVERLAP {
            self.remarks.push(format!(
                "{}: intervals overlap by {overlap:.2}",
                finding.effect
            ));
        }
    }

    /// Compares the parameters.
    fn check_parameters(&mut self, concealed: &ConcealedEffect, finding: &ReportedFinding) {
        for (name, truth) in &concealed.parameters {
            if matches!(truth, ParameterValue::List(_)) {
                // An answer has no lists.
                continue;
            }
            let Some(reported) = finding
                .parameters
                .iter()
                .find(|reported| reported.name == *name)
            else {
                self.remarks
                    .push(format!("{}.{name} is not given", concealed.effect));
                continue;
            };
            match truth {
                ParameterValue::Text(text) if reported.text.as_ref() == Some(text) => {}
                ParameterValue::Text(text) => {
                    self.remarks
                        .push(format!("{}.{name} is not {text}", concealed.effect));
                }
                ParameterValue::Number(truth) => self.score_parameter(concealed, *truth, reported),
                ParameterValue::List(_) => {}
            }
        }
    }

    /// Scores one numeric parameter.
    fn score_parameter(
        &mut self,
        concealed: &ConcealedEffect,
        truth: f64,
        reported: &ReportedParameter,
    ) {
        let Some(estimate) = reported.estimate else {
            self.remarks.push(format!(
                "{}.{} has no estimate",
                concealed.effect, reported.name
            ));
            return;
        };
        // For directions, whole turns that bring the estimate nearest to the truth.
        let turn = nearest_turn(&concealed.effect, &reported.name, truth, estimate);
        let error = estimate + turn - truth;
        let interval = reported.interval();
        let covered = interval.map(|[low, high]| low <= truth - turn && truth - turn <= high);
        let tolerance = concealed.tolerances.get(&reported.name).copied();
        let tolerance = f64::max(RELATIVE_TOLERANCE * truth.abs(), tolerance.unwrap_or(0.0));
        if covered != Some(true) && error.abs() > tolerance {
            let words = format!(
                "{}.{} {estimate:.6}, not {truth:.6}",
                concealed.effect, reported.name
            );
            self.remarks.push(words);
        }
        let stated = interval.map(|[low, high]| (high - low) / (2.0 * NORMAL_QUANTILE_975));
        let least = concealed.deviations.get(&reported.name).copied();
        let ratio = |deviation: f64| (deviation > 0.0).then(|| error / deviation);
        self.parameters.push(ParameterScore {
            effect: concealed.effect.clone(),
            name: reported.name.clone(),
            truth,
            estimate,
            covered,
            error_in_stated_deviations: stated.and_then(ratio),
            error_in_least_deviations: least.and_then(ratio),
        });
    }

    /// The grade; findings not matched by now report effects that are not there.
    fn grade(&mut self, label: &Label) -> TrialGrade {
        let nothing = label.is_null();
        let flags = self
            .unmatched
            .iter()
            .filter(|finding| finding.effect == "unknown")
            .count();
        let wrong = self.unmatched.len() - flags;
        for finding in std::mem::take(&mut self.unmatched) {
            let ReportedFinding { effect, robot, .. } = finding;
            self.remarks
                .push(format!("{effect} of {robot} is not there"));
            self.pairs.push(["none".to_owned(), effect.clone()]);
        }
        if nothing && self.pairs.is_empty() {
            self.pairs.push(["none".to_owned(), "none".to_owned()]);
        }
        match () {
            () if nothing && wrong + flags > 0 => TrialGrade::FalseAlarm,
            () if nothing && !self.remarks.is_empty() && label.nuisances.is_empty() => {
                TrialGrade::FalseAlarm
            }
            () if wrong > 0 => TrialGrade::Wrong,
            () if self.missed > 0 && flags > 0 => TrialGrade::Flagged,
            () if self.missed > 0 => TrialGrade::Missed,
            () if self.look_alikes > 0 => TrialGrade::LookAlike,
            () if self.remarks.is_empty() => TrialGrade::Exact,
            () => TrialGrade::Inexact,
        }
    }
}

/// Distance of a finding's parameters from the truth, to match effects that occur more than once.
fn distance(concealed: &ConcealedEffect, finding: &ReportedFinding) -> f64 {
    let reported: BTreeMap<&str, &ReportedParameter> = finding
        .parameters
        .iter()
        .map(|reported| (reported.name.as_str(), reported))
        .collect();
    let part =
        |(name, truth): (&String, &ParameterValue)| match (truth, reported.get(name.as_str())) {
            (ParameterValue::Number(truth), Some(reported)) => reported
                .estimate
                .map_or(1.0, |estimate| (estimate - truth).abs()),
            (ParameterValue::Text(text), Some(reported))
                if reported.text.as_ref() == Some(text) =>
            {
                0.0
            }
            (ParameterValue::List(_), _) => 0.0,
            _ => 1e3,
        };
    concealed.parameters.iter().map(part).sum()
}

/// Whole turns (rad) to add to an estimated direction so that it is nearest to the truth; 0 for other
/// parameters.
fn nearest_turn(effect: &str, name: &str, truth: f64, estimate: f64) -> f64 {
    let parameter = find(effect).and_then(|info| info.parameter(name));
    if parameter.is_some_and(|parameter| parameter.role == Role::Direction) {
        ((truth - estimate) / TAU).round() * TAU
    } else {
        0.0
    }
}
