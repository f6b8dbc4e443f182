//! Recordings diagnosed one after the other; then the labels, and the marks.

use std::path::Path;

use crate::TrialError;
use crate::examine::{Case, Examined, Examiner};
use crate::label::Labels;
use crate::mark::{failed, mark};
use crate::tally::Entry;

/// What a diagnosis is asked: no more than what it may know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// The recording's folder, in the trial's.
    pub name: String,
    /// The nominal model's file, in the trial's folder.
    pub model: String,
    /// Effects that are taken out of the catalogue.
    pub without: Vec<String>,
}

/// Diagnoses each case in `folder`; `done` hears of each.
///
/// # Errors
/// As [`Examiner::diagnose`].
pub fn ask(
    examiner: &Examiner<'_>,
    folder: &Path,
    questions: &[Question],
    mut done: impl FnMut(&Question, &Examined),
) -> Result<Vec<Examined>, TrialError> {
    let mut answers = Vec::new();
    for question in questions {
        let examined = examiner.diagnose(&Case {
            recording: &folder.join(&question.name),
            model: &folder.join(&question.model),
            without: &question.without,
        })?;
        done(question, &examined);
        answers.push(examined);
    }
    Ok(answers)
}

/// The questions of labelled folders, `without` taken out of every catalogue.
pub fn questions(labels: &Labels, without: &[String]) -> Vec<Question> {
    let question = |(name, label): (&String, &crate::label::Label)| Question {
        name: name.clone(),
        model: label.robot_toml.clone(),
        without: [without, label.without.as_slice()].concat(),
    };
    labels.iter().map(question).collect()
}

/// Marks the answers to `questions` by the labels.
pub fn score(labels: &Labels, questions: &[Question], answers: Vec<Examined>) -> Vec<Entry> {
    let both = questions.iter().zip(answers);
    let entry = |(question, examined): (&Question, Examined)| {
        let label = labels.get(&question.name)?;
        Some(Entry {
            case: question.name.clone(),
            kind: label.kind.clone(),
            mark: match examined.answer {
                Ok(answer) => mark(label, &answer),
                Err(why) => failed(label, why),
            },
            label: label.clone(),
            seconds: examined.seconds,
        })
    };
    both.filter_map(entry).collect()
}
