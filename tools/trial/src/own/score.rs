//! Scores of a trial on somebody's own recording.

use serde::{Deserialize, Serialize};

use super::change::{Change, is_factor};
use super::made::OwnCase;
use crate::answer::DiagnosisAnswer;
use crate::diagnosis_process::DiagnosisRun;
use crate::grade::{TrialGrade, grade, no_answer};
use crate::tally::{ScoredCase, TrialReport, tally};

/// What would be found on this robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Detectable {
    /// The effect.
    pub effect: String,
    /// Its parameter.
    pub parameter: String,
    /// The smallest change that was found, as every larger one; null where none was.
    pub smallest: Option<f64>,
    /// The sizes that were tried, rising, and whether each was found.
    pub tried: Vec<(f64, bool)>,
}

/// The result of a trial on somebody's own recording (`--json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OwnReport {
    /// The scores.
    #[serde(flatten)]
    pub trial: TrialReport,
    /// The recording.
    pub on: String,
    /// Copies that were to be diagnosed: as many as there are cases, unless it was interrupted.
    pub planned: usize,
    /// What would be found, and down to which size.
    pub detectable: Vec<Detectable>,
    /// Copies with a change that was missed and that their diagnosis calls too small to be seen.
    pub out_of_sight: Vec<String>,
}

impl OwnReport {
    /// Whole copies with a change: how many, how many of them exact, and how many with a change out of sight.
    pub fn whole(&self) -> [usize; 3] {
        let whole = self.trial.each.iter().filter(|own| own.kind == "whole");
        whole.fold([0; 3], |[all, exact, hidden], own| {
            let is_exact = own.score.grade == TrialGrade::Exact;
            let is_hidden = self.out_of_sight.contains(&own.case);
            [
                all + 1,
                exact + usize::from(is_exact),
                hidden + usize::from(is_hidden),
            ]
        })
    }
}

/// Scores the answers to `cases`, or to the first of them.
pub fn score(on: &str, cases: &[OwnCase], answers: Vec<DiagnosisRun>) -> OwnReport {
    let hidden = cases.iter().zip(&answers);
    let hidden = hidden.filter(|(case, run)| {
        let answer = run.answer.as_ref();
        let seen = |answer: &DiagnosisAnswer| !answer.findings.is_empty();
        let change = case.change.as_ref();
        answer.is_ok_and(|own| !seen(own) && change.is_some_and(|c| is_hidden(c, own)))
    });
    let out_of_sight = hidden.map(|(case, _)| case.name.clone()).collect();
    let both = cases.iter().zip(answers);
    let each: Vec<ScoredCase> = both
        .map(|(case, run)| ScoredCase {
            case: case.name.clone(),
            kind: case.kind.clone(),
            score: match run.answer {
                Ok(answer) => grade(&case.label, &as_changes(answer)),
                Err(why) => no_answer(&case.label, why, run.refused),
            },
            label: case.label.clone(),
            seconds: Some(run.seconds),
        })
        .collect();
    let detectable = detectable(cases, &each);
    let interrupted = each.len() < cases.len();
    OwnReport {
        trial: TrialReport {
            interrupted,
            ..tally(each, Vec::new(), None)
        },
        on: on.to_owned(),
        planned: cases.len(),
        detectable,
        out_of_sight,
    }
}

/// Whether an answer says that it would not have seen a change of this size.
fn is_hidden(change: &Change, answer: &DiagnosisAnswer) -> bool {
    let limits = |name: &str| {
        let own = change.shown_by(name);
        let all = answer.detectable.iter();
        all.filter(move |limit| own.contains(&(limit.effect.as_str(), limit.parameter.as_str())))
    };
    let below = |name: &str, size: f64| {
        let mut own = limits(name);
        own.any(|limit| limit.smallest.is_none_or(|own| size < own))
    };
    let mut all = change.distances().into_iter();
    all.all(|(name, size)| size == 0.0 || below(name, size))
}

/// The answer with changes in the place of values: differences, or factors where the parameter is one.
fn as_changes(mut answer: DiagnosisAnswer) -> DiagnosisAnswer {
    for finding in &mut answer.findings {
        for parameter in &mut finding.parameters {
            let is_factor = is_factor(&finding.effect, &parameter.name);
            let nominal = parameter
                .nominal
                .unwrap_or(if is_factor { 1.0 } else { 0.0 });
            let change = |value: f64| {
                if is_factor {
                    value / nominal
                } else {
                    value - nominal
                }
            };
            parameter.estimate = parameter.estimate.map(change);
            parameter.ci95 = parameter.ci95.map(|ends| ends.map(|end| end.map(change)));
        }
    }
    answer
}

fn detectable(cases: &[OwnCase], each: &[ScoredCase]) -> Vec<Detectable> {
    let mut all: Vec<Detectable> = Vec::new();
    for (case, scored) in cases.iter().zip(each) {
        let Some(change) = case.change.filter(|_| case.kind == "whole") else {
            continue;
        };
        let (parameter, size) = change.size();
        let found = matches!(
            scored.score.grade,
            TrialGrade::Exact | TrialGrade::LookAlike
        );
        let same =
            |own: &&mut Detectable| own.effect == change.effect() && own.parameter == parameter;
        match all.iter_mut().find(same) {
            Some(own) => own.tried.push((size, found)),
            None => all.push(Detectable {
                effect: change.effect().to_owned(),
                parameter: parameter.to_owned(),
                smallest: None,
                tried: vec![(size, found)],
            }),
        }
    }
    for own in &mut all {
        own.tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let found = own.tried.iter().rev().take_while(|(_, found)| *found);
        own.smallest = found.last().map(|(size, _)| *size);
    }
    all
}
