//! The results of a trial, summed up over its cases.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::grade::{AnswerFlag, CaseScore, ParameterScore, TrialGrade};
use crate::label::Label;
use crate::part::TrialPart;

/// The result of a trial (`--json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialReport {
    /// Version of this format.
    pub format: u32,
    /// Number of cases.
    pub cases: usize,
    /// Number of cases without a concealed effect.
    pub nulls: usize,
    /// Cases graded exact.
    pub exact: usize,
    /// Cases graded inexact.
    pub inexact: usize,
    /// Cases with a declared look-alike reported.
    pub look_alike: usize,
    /// Cases with an effect of the vocabulary reported as unknown.
    pub flagged: usize,
    /// Cases with an effect not found.
    pub missed: usize,
    /// Cases with a wrong effect reported.
    pub wrong: usize,
    /// Cases with something reported although nothing is there.
    pub false_alarms: usize,
    /// Cases without an answer.
    pub failed: usize,
    /// Cases whose input was called unusable.
    #[serde(default)]
    pub refused: usize,
    /// Answers with a confident verdict beside a prediction error that does not allow it.
    #[serde(default)]
    pub contradictions: usize,
    /// Answers with a line of the budget that grows by the findings.
    #[serde(default)]
    pub worse: usize,
    /// Nuisance → counts of the cases that have it; `none` for those without any. Empty if no label names one.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub nuisances: BTreeMap<String, NuisanceCounts>,
    /// Kind of case → grade → count.
    pub kinds: BTreeMap<String, BTreeMap<Cow<'static, str>, usize>>,
    /// Kind of case → counts of its cases.
    #[serde(default)]
    pub families: BTreeMap<String, FamilyCounts>,
    /// True effect → reported effect → count.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Share of the 95 % intervals that contain the true value; null without any.
    pub coverage95: Option<f64>,
    /// Root mean square of the parameter errors, in standard deviations as stated by the answers.
    pub error_over_stated: Option<f64>,
    /// The same in the smallest deviations possible, where the labels have them.
    pub error_over_least: Option<f64>,
    /// Median of the relative parameter errors.
    pub median_relative_error: Option<f64>,
    /// Median ratio of the prediction error with the findings to that of the nominal model, over cases with
    /// findings.
    pub held_out_ratio: Option<f64>,
    /// Identified and missed effects by size.
    pub detection: Vec<DetectionRate>,
    /// Median and largest duration of a diagnosis (s). Not in the JSON, which is the same on every machine.
    #[serde(skip)]
    pub seconds: Option<[f64; 2]>,
    /// Which part of which trial this is; absent with `--on`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<TrialPart>,
    /// Whether it was interrupted: only the cases that were diagnosed before are there.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub interrupted: bool,
    /// Commitment of each case: SHA-256 of nonce and label.
    pub commitments: Vec<String>,
    /// All cases.
    pub each: Vec<ScoredCase>,
}

impl TrialReport {
    /// Cases in which something is concealed: how many, and how many of them were answered exactly.
    pub fn concealed(&self) -> [usize; 2] {
        let concealed = self.each.iter().filter(|own| !own.label.is_null());
        concealed.fold([0; 2], |[all, exact], own| {
            let is_exact = own.score.grade == TrialGrade::Exact;
            [all + 1, exact + usize::from(is_exact)]
        })
    }
}

/// The cases of one kind, counted by grade.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FamilyCounts {
    /// Number of cases.
    pub cases: usize,
    /// Graded exact.
    pub exact: usize,
    /// Graded inexact.
    pub inexact: usize,
    /// A declared look-alike reported.
    pub look_alike: usize,
    /// An effect of the vocabulary reported as unknown.
    pub flagged: usize,
    /// An effect not found.
    pub missed: usize,
    /// A wrong effect reported.
    pub wrong: usize,
    /// Something reported although nothing is there.
    pub false_alarms: usize,
    /// Without an answer.
    pub failed: usize,
}

impl FamilyCounts {
    fn add(&mut self, grade: TrialGrade) {
        self.cases += 1;
        *match grade {
            TrialGrade::Exact => &mut self.exact,
            TrialGrade::Inexact => &mut self.inexact,
            TrialGrade::LookAlike => &mut self.look_alike,
            TrialGrade::Flagged => &mut self.flagged,
            TrialGrade::Missed => &mut self.missed,
            TrialGrade::Wrong => &mut self.wrong,
            TrialGrade::FalseAlarm => &mut self.false_alarms,
            TrialGrade::Failed => &mut self.failed,
        } += 1;
    }
}

/// The cases that have one nuisance, counted by what came of them. A case has several nuisances, and counts for each.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NuisanceCounts {
    /// Number of cases.
    pub cases: usize,
    /// Graded exact, or a declared look-alike.
    pub right: usize,
    /// Graded inexact.
    pub inexact: usize,
    /// An effect not found, or reported as unknown.
    pub missed: usize,
    /// Something reported that is not there.
    pub wrong: usize,
    /// Without an answer.
    pub failed: usize,
    /// The input was called unusable: among those without an answer.
    pub refused: usize,
    /// A confident verdict beside a prediction error that does not allow it.
    pub contradictions: usize,
    /// A line of the budget that grows by the findings.
    pub worse: usize,
}

impl NuisanceCounts {
    /// All counts with their names, in the order of a table.
    pub fn columns(&self) -> [(&'static str, usize); 9] {
        [
            ("cases", self.cases),
            ("right", self.right),
            ("inexact", self.inexact),
            ("missed", self.missed),
            ("wrong", self.wrong),
            ("failed", self.failed),
            ("refused", self.refused),
            ("contradictions", self.contradictions),
            ("worse", self.worse),
        ]
    }

    fn add(&mut self, score: &CaseScore) {
        self.cases += 1;
        *match score.grade {
            TrialGrade::Exact | TrialGrade::LookAlike => &mut self.right,
            TrialGrade::Inexact => &mut self.inexact,
            TrialGrade::Flagged | TrialGrade::Missed => &mut self.missed,
            TrialGrade::Wrong | TrialGrade::FalseAlarm => &mut self.wrong,
            TrialGrade::Failed => &mut self.failed,
        } += 1;
        for flag in &score.flags {
            *match flag {
                AnswerFlag::Refused => &mut self.refused,
                AnswerFlag::Contradiction => &mut self.contradictions,
                AnswerFlag::Worse => &mut self.worse,
            } += 1;
        }
    }
}

/// One case with its score.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScoredCase {
    /// Its name.
    pub case: String,
    /// Kind of case.
    pub kind: String,
    /// Its score.
    #[serde(flatten)]
    pub score: CaseScore,
    /// Its label.
    pub label: Label,
    /// Duration of the diagnosis (s); not in the JSON.
    #[serde(skip)]
    pub seconds: Option<f64>,
}

/// Detection of the effects of one size, by the expected gain of the true model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DetectionRate {
    /// Lower bound of the expected gain (nats); the upper bound is four times as large.
    pub from_gain: f64,
    /// Number of effects.
    pub effects: usize,
    /// Number identified.
    pub named: usize,
    /// Number taken for a declared look-alike.
    pub look_alike: usize,
    /// Number not found.
    pub missed: usize,
}

/// Sums up the cases of a trial, or of a part of it.
pub fn tally(
    each: Vec<ScoredCase>,
    commitments: Vec<String>,
    part: Option<TrialPart>,
) -> TrialReport {
    let count = |outcome| {
        each.iter()
            .filter(|entry| entry.score.grade == outcome)
            .count()
    };
    let noted = |flag| {
        each.iter()
            .filter(|entry| entry.score.flags.contains(&flag))
            .count()
    };
    let parameters = || each.iter().flat_map(|entry| &entry.score.parameters);
    let covered: Vec<bool> = parameters().filter_map(|p| p.covered).collect();
    let hits = covered.iter().filter(|covered| **covered).count();
    let relative =
        |p: &ParameterScore| (p.truth != 0.0).then(|| ((p.estimate - p.truth) / p.truth).abs());
    let named = each
        .iter()
        .filter(|entry| entry.score.pairs.iter().any(|[_, said]| said != "none"));
    let ratio =
        named.filter_map(|entry| entry.score.held_out.map(|[before, after]| after / before));
    let seconds = || each.iter().filter_map(|entry| entry.seconds);
    TrialReport {
        format: 1,
        cases: each.len(),
        nulls: each.iter().filter(|own| own.label.is_null()).count(),
        exact: count(TrialGrade::Exact),
        inexact: count(TrialGrade::Inexact),
        look_alike: count(TrialGrade::LookAlike),
        flagged: count(TrialGrade::Flagged),
        missed: count(TrialGrade::Missed),
        wrong: count(TrialGrade::Wrong),
        false_alarms: count(TrialGrade::FalseAlarm),
        failed: count(TrialGrade::Failed),
        refused: noted(AnswerFlag::Refused),
        contradictions: noted(AnswerFlag::Contradiction),
        worse: noted(AnswerFlag::Worse),
        nuisances: nuisances(&each),
        kinds: kinds(&each),
        families: families(&each),
        confusion: confusion(&each),
        coverage95: (!covered.is_empty()).then(|| hits as f64 / covered.len() as f64),
        error_over_stated: rms(parameters().filter_map(|p| p.error_in_stated_deviations)),
        error_over_least: rms(parameters().filter_map(|p| p.error_in_least_deviations)),
        median_relative_error: median(parameters().filter_map(relative)),
        held_out_ratio: median(ratio),
        detection: detection(&each),
        seconds: median(seconds())
            .zip(seconds().reduce(f64::max))
            .map(Into::into),
        interrupted: part.as_ref().is_some_and(|own| each.len() < own.count()),
        part,
        commitments,
        each,
    }
}

fn kinds(each: &[ScoredCase]) -> BTreeMap<String, BTreeMap<Cow<'static, str>, usize>> {
    let mut kinds: BTreeMap<String, BTreeMap<Cow<'static, str>, usize>> = BTreeMap::new();
    for entry in each {
        let grades = kinds.entry(entry.kind.clone()).or_default();
        *grades.entry(entry.score.grade.name().into()).or_default() += 1;
    }
    kinds
}

fn families(each: &[ScoredCase]) -> BTreeMap<String, FamilyCounts> {
    let mut families: BTreeMap<String, FamilyCounts> = BTreeMap::new();
    for entry in each {
        let family = families.entry(entry.kind.clone()).or_default();
        family.add(entry.score.grade);
    }
    families
}

fn nuisances(each: &[ScoredCase]) -> BTreeMap<String, NuisanceCounts> {
    let mut nuisances: BTreeMap<String, NuisanceCounts> = BTreeMap::new();
    if each.iter().all(|entry| entry.label.nuisances.is_empty()) {
        return nuisances;
    }
    let none = ["none".to_owned()];
    for entry in each {
        let own = match entry.label.nuisances.as_slice() {
            [] => &none,
            own => own,
        };
        for name in own {
            nuisances.entry(name.clone()).or_default().add(&entry.score);
        }
    }
    nuisances
}

fn confusion(each: &[ScoredCase]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for [truth, said] in each.iter().flat_map(|entry| &entry.score.pairs) {
        *confusion
            .entry(truth.clone())
            .or_default()
            .entry(said.clone())
            .or_default() += 1;
    }
    confusion
}

/// Effects of known size, in bins of a factor of four in the gain (a factor of two in the parameter).
fn detection(each: &[ScoredCase]) -> Vec<DetectionRate> {
    let mut steps: BTreeMap<i32, DetectionRate> = BTreeMap::new();
    for entry in each {
        // The pairs of the true effects come first, in the order of the label.
        for (concealed, [truth, said]) in entry.label.effects.iter().zip(&entry.score.pairs) {
            let Some(gain) = concealed.expected_gain.filter(|gain| *gain > 0.0) else {
                continue;
            };
            let step = gain.log(4.0).floor();
            let at = steps.entry(step as i32).or_insert(DetectionRate {
                from_gain: 4f64.powf(step),
                effects: 0,
                named: 0,
                look_alike: 0,
                missed: 0,
            });
            at.effects += 1;
            match said.as_str() {
                _ if said == truth => at.named += 1,
                "none" | "failed" => at.missed += 1,
                _ => at.look_alike += 1,
            }
        }
    }
    steps.into_values().collect()
}

fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| {
        (sum + value * value, count + 1)
    });
    (count > 0).then(|| (sum / f64::from(count)).sqrt())
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let (low, high) = (
        values.get(values.len().checked_sub(1)? / 2)?,
        values.get(values.len() / 2)?,
    );
    Some((low + high) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_rms() {
        assert_eq!(median([3.0, 1.0].into_iter()), Some(2.0));
        assert_eq!(median([5.0, 3.0, 1.0].into_iter()), Some(3.0));
        assert_eq!(median(std::iter::empty()), None);
        assert_eq!(rms([3.0, -3.0].into_iter()), Some(3.0));
    }
}
