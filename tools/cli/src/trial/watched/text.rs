//! The scores of a watch in words.

use super::kinds::MULTIPLES;
use super::scored::{Case, Scores};
use crate::print::{print_line, prints};

/// What is aimed at: a change is raised within so long (s) or so far (m), its onset known to that (s).
const WITHIN_S: f64 = 3.0;
const WITHIN_M: f64 = 2.0;
const ONSET_S: f64 = 1.0;

/// Prints scores.
pub(super) fn print(scores: &Scores) {
    let minutes = scores.heard_s / 60.0;
    let false_alarms: usize = scores.cases.iter().map(|own| own.false_alarms.len()).sum();
    print_line!(
        "{}: {minutes:.1} min heard, changes begin after {:.0} s; alarms without a change: {} in the unchanged copy, {false_alarms} before \
         {} changes",
        scores.on,
        scores.onset_s,
        scores.null_alarms.len(),
        scores.cases.len()
    );
    print_line!(
        "size over the smallest that the rest would show: raised, named right, onset within {ONSET_S} s, size in interval; \
        median delay and what the information allows"
    );
    for multiple in MULTIPLES {
        let all: Vec<&Case> = scores
            .cases
            .iter()
            .filter(|own| own.multiple == multiple)
            .collect();
        if all.is_empty() {
            continue;
        }
        let raised = all.iter().filter(|own| own.delay_s.is_some()).count();
        let named = all.iter().filter(|own| own.is_named).count();
        let onset = all
            .iter()
            .filter(|own| own.onset_error_s.is_some_and(|own| own.abs() <= ONSET_S))
            .count();
        let sized: Vec<bool> = all.iter().filter_map(|own| own.in_interval).collect();
        let soon = all.iter().filter(|own| is_soon(own)).count();
        let within = sized.iter().filter(|own| **own).count();
        print_line!(
            "  {multiple} x: {raised} of {} raised, {soon} within {WITHIN_S} s or {WITHIN_M} m, {named} named, {onset} onsets, {within} of {} \
             sizes; {} s (limit {} s)",
            all.len(),
            sized.len(),
            median(all.iter().map(|own| own.delay_s)),
            median(all.iter().map(|own| own.limit_s)),
        );
    }
    if prints().details {
        for case in &scores.cases {
            print_line!("  {}", words(case));
        }
    }
}

fn is_soon(own: &Case) -> bool {
    own.delay_s.is_some_and(|own| own <= WITHIN_S) || own.way_m.is_some_and(|own| own <= WITHIN_M)
}

/// The median; of what never happened, the longest.
fn median(all: impl Iterator<Item = Option<f64>>) -> String {
    let mut all: Vec<f64> = all.map(|own| own.unwrap_or(f64::INFINITY)).collect();
    all.sort_by(f64::total_cmp);
    let own = all.get(all.len() / 2).copied().unwrap_or(f64::INFINITY);
    if own.is_finite() {
        format!("{own:.1}")
    } else {
        "no".to_owned()
    }
}

fn words(own: &Case) -> String {
    let seconds = |own: Option<f64>| own.map_or("never".to_owned(), |own| format!("{own:.1} s"));
    let name = |own: &Option<String>| own.clone().unwrap_or_else(|| "nothing".to_owned());
    format!(
        "{} {}{} {:+.4} ({} x): raised after {} (limit {}), as {}, at last {}, onset off {}, in interval {:?}{}",
        own.effect,
        own.parameter,
        if own.both { " (both)" } else { "" },
        own.size,
        own.multiple,
        seconds(own.delay_s),
        seconds(own.limit_s),
        name(&own.raised_as),
        name(&own.named_as),
        seconds(own.onset_error_s),
        own.in_interval,
        match own.false_alarms.as_slice() {
            [] => String::new(),
            all => format!("; false: {}", all.join(", ")),
        },
    )
}
