//! Merges the shards of a trial into the report of the whole trial, as if one process had scored it.

use slipstream_bus::{InputError, Shard};

use crate::part::TrialPart;
use crate::tally::{TrialReport, tally};

/// Merges all shards of one trial, given with the names of their files.
///
/// # Errors
/// A report that is no shard of a trial; shards of different trials; a shard that is missing, given twice, or
/// lacks a case.
pub fn merge(files: &[(String, TrialReport)]) -> Result<TrialReport, InputError> {
    let parts = files
        .iter()
        .map(|(name, report)| Ok((name.clone(), (part(name, report)?, report))))
        .collect::<Result<Vec<_>, InputError>>()?;
    let shards = Shard::in_order(
        &parts,
        "trial",
        |(part, _)| part.shard,
        |(one, _), (other, _)| one.is_of_the_trial_of(other),
    )?;
    let whole = shards[0].0.whole();
    let of = shards.len();
    let turns = || (0..whole.cases).map(|index| (shards[index % of].1, index / of));
    let each = turns().map(|(report, at)| report.each[at].clone());
    let commitments = turns().filter_map(|(report, at)| report.commitments.get(at).cloned());
    Ok(tally(
        each.collect(),
        commitments.collect(),
        Some(whole.clone()),
    ))
}

/// What a report says about itself; it must have all of its cases.
fn part<'a>(name: &str, report: &'a TrialReport) -> Result<&'a TrialPart, InputError> {
    let Some(part) = &report.part else {
        let remedy = "give files that `slipstream trial --shard I/N --json FILE` wrote";
        return Err(InputError::new(name, "is no shard of a trial", remedy));
    };
    let commitments = if part.labels.is_some() {
        0
    } else {
        part.count()
    };
    if report.each.len() != part.count() || report.commitments.len() != commitments {
        let problem = format!("shard {} lacks a case", part.shard);
        return Err(InputError::new(name, problem, "run it again"));
    }
    Ok(part)
}
