//! Labelled folders diagnosed one after the other, and judged.

use std::path::Path;

use crate::TrialError;
use crate::examine::{Case, Examiner};
use crate::label::Labels;
use crate::mark::{failed, mark};
use crate::tally::Entry;

/// Diagnoses each case of `labels` that stands in `folder`, then opens its label.
///
/// `without` is taken out of every diagnosis's catalogue; `done` hears of each case.
///
/// # Errors
/// As [`Examiner::diagnose`].
pub fn hold(
    examiner: &Examiner<'_>,
    folder: &Path,
    labels: &Labels,
    without: &[String],
    mut done: impl FnMut(&Entry),
) -> Result<Vec<Entry>, TrialError> {
    let mut entries = Vec::new();
    for (name, label) in labels {
        let without = [without, label.without.as_slice()].concat();
        let examined = examiner.diagnose(&Case {
            recording: &folder.join(name),
            model: &folder.join(&label.robot_toml),
            without: &without,
        })?;
        let entry = Entry {
            case: name.clone(),
            kind: label.kind.clone(),
            mark: match examined.answer {
                Ok(answer) => mark(label, &answer),
                Err(why) => failed(label, why),
            },
            label: label.clone(),
            seconds: examined.seconds,
        };
        done(&entry);
        entries.push(entry);
    }
    Ok(entries)
}
