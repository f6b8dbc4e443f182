//! Many marks together.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::label::Label;
use crate::mark::{Mark, Outcome};

/// How a trial went (`--json`).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Version of this form.
    pub format: u32,
    /// How many cases.
    pub cases: usize,
    /// Of those, the ones in which nothing was concealed.
    pub nulls: usize,
    /// Everything right.
    pub exact: usize,
    /// Effects and robots right, a parameter, an interval or a channel not.
    pub inexact: usize,
    /// A declared look-alike was named.
    pub look_alike: usize,
    /// Flagged as unknown, where the vocabulary has it.
    pub flagged: usize,
    /// Not found.
    pub missed: usize,
    /// Named what is not there.
    pub wrong: usize,
    /// Named or flagged something where nothing is.
    pub false_alarms: usize,
    /// No answer.
    pub failed: usize,
    /// What drew the cases → outcome → how often.
    pub kinds: BTreeMap<String, BTreeMap<&'static str, usize>>,
    /// What was there → what was named → how often.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Share of the 95 % intervals that hold the truth; null without any.
    pub coverage95: Option<f64>,
    /// Root mean square of parameter errors, in the deviations that the answers state.
    pub error_over_stated: Option<f64>,
    /// The same in the smallest deviations possible, where the labels have them.
    pub error_over_least: Option<f64>,
    /// Median of parameter errors in proportion to the truth.
    pub median_relative_error: Option<f64>,
    /// Median of the prediction error after, in proportion to before, where something was named.
    pub held_out_ratio: Option<f64>,
    /// Found and missed by size.
    pub detection: Vec<Detection>,
    /// Median and largest time for one diagnosis (s).
    pub seconds: [f64; 2],
    /// SHA-256 of each sealed label with its nonce.
    pub commitments: Vec<String>,
    /// Each case.
    pub each: Vec<Entry>,
}

/// One case in the report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Its name.
    pub case: String,
    /// What drew it.
    pub kind: String,
    /// How it went.
    #[serde(flatten)]
    pub mark: Mark,
    /// What was there.
    pub label: Label,
    /// How long the diagnosis took (s).
    pub seconds: f64,
}

/// Effects of one size, by the expected gain of the true model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detection {
    /// From this many nats on, up to four times as many.
    pub from_gain: f64,
    /// How many there were.
    pub effects: usize,
    /// How many were named right.
    pub named: usize,
    /// How many were taken for a declared look-alike.
    pub look_alike: usize,
    /// How many were not found.
    pub missed: usize,
}

/// Adds up.
pub fn tally(each: Vec<Entry>, commitments: Vec<String>) -> Report {
    let count = |outcome| {
        each.iter()
            .filter(|entry| entry.mark.outcome == outcome)
            .count()
    };
    let parameters = || each.iter().flat_map(|entry| &entry.mark.parameters);
    let covered: Vec<bool> = parameters().filter_map(|p| p.covered).collect();
    let hits = covered.iter().filter(|covered| **covered).count();
    let relative = |p: &crate::mark::ParameterMark| {
        (p.truth != 0.0).then(|| ((p.estimate - p.truth) / p.truth).abs())
    };
    let named = each
        .iter()
        .filter(|entry| entry.mark.pairs.iter().any(|[_, said]| said != "none"));
    let ratio = named.filter_map(|entry| entry.mark.held_out.map(|[before, after]| after / before));
    let mut seconds: Vec<f64> = each.iter().map(|entry| entry.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let nothing = |entry: &&Entry| entry.label.effects.is_empty() && entry.label.unknown.is_none();
    Report {
        format: 1,
        cases: each.len(),
        nulls: each.iter().filter(nothing).count(),
        exact: count(Outcome::Exact),
        inexact: count(Outcome::Inexact),
        look_alike: count(Outcome::LookAlike),
        flagged: count(Outcome::Flagged),
        missed: count(Outcome::Missed),
        wrong: count(Outcome::Wrong),
        false_alarms: count(Outcome::FalseAlarm),
        failed: count(Outcome::Failed),
        kinds: kinds(&each),
        confusion: confusion(&each),
        coverage95: (!covered.is_empty()).then(|| hits as f64 / covered.len() as f64),
        error_over_stated: rms(parameters().filter_map(|p| p.error_in_stated_deviations)),
        error_over_least: rms(parameters().filter_map(|p| p.error_in_least_deviations)),
        median_relative_error: median(parameters().filter_map(relative)),
        held_out_ratio: median(ratio),
        detection: detection(&each),
        seconds: [
            median(seconds.iter().copied()).unwrap_or(0.0),
            seconds.last().copied().unwrap_or(0.0),
        ],
        commitments,
        each,
    }
}

fn kinds(each: &[Entry]) -> BTreeMap<String, BTreeMap<&'static str, usize>> {
    let mut kinds: BTreeMap<String, BTreeMap<&str, usize>> = BTreeMap::new();
    for entry in each {
        let outcomes = kinds.entry(entry.kind.clone()).or_default();
        *outcomes.entry(entry.mark.outcome.name()).or_default() += 1;
    }
    kinds
}

fn confusion(each: &[Entry]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for [truth, said] in each.iter().flat_map(|entry| &entry.mark.pairs) {
        *confusion
            .entry(truth.clone())
            .or_default()
            .entry(said.clone())
            .or_default() += 1;
    }
    confusion
}

/// Effects of known size, in steps of a factor of four (a factor of two in the parameter).
fn detection(each: &[Entry]) -> Vec<Detection> {
    let mut steps: BTreeMap<i32, Detection> = BTreeMap::new();
    for entry in each {
        // the pairs of what is there come first, in the label's order
        for (hidden, [truth, said]) in entry.label.effects.iter().zip(&entry.mark.pairs) {
            let Some(gain) = hidden.expected_gain.filter(|gain| *gain > 0.0) else {
                continue;
            };
            let step = gain.log(4.0).floor();
            let at = steps.entry(step as i32).or_insert(Detection {
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
    fn medians_and_means_are_what_they_are_called() {
        assert_eq!(median([3.0, 1.0].into_iter()), Some(2.0));
        assert_eq!(median([5.0, 3.0, 1.0].into_iter()), Some(3.0));
        assert_eq!(median(std::iter::empty()), None);
        assert_eq!(rms([3.0, -3.0].into_iter()), Some(3.0));
    }
}
