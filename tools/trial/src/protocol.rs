//! The protocol of a trial: diagnose the recordings one by one, then score the answers.

use std::path::Path;

use crate::TrialError;
use crate::diagnosis_process::{DiagnosisInput, DiagnosisProgram, DiagnosisRun};
use crate::grade::{grade, no_answer};
use crate::label::Labels;
use crate::tally::ScoredCase;

/// One case as the diagnosis gets it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// Folder of the recording, in the folder of the trial.
    pub name: String,
    /// File of the nominal model, in the folder of the trial.
    pub model: String,
    /// Effects removed from the catalogue.
    pub without: Vec<String>,
}

/// Diagnoses every case in `folder` and calls `done` after each. An interruption ends it: the answers so far are
/// returned.
///
/// # Errors
/// As [`DiagnosisProgram::diagnose`], and an interruption before the first answer.
pub fn diagnose_all(
    program: &DiagnosisProgram<'_>,
    folder: &Path,
    questions: &[Question],
    mut done: impl FnMut(&Question, &DiagnosisRun),
) -> Result<Vec<DiagnosisRun>, TrialError> {
    until_interrupted(questions, |question| {
        let run = program.diagnose(&DiagnosisInput {
            recording: &folder.join(&question.name),
            against: None,
            model: &folder.join(&question.model),
            without: &question.without,
        })?;
        done(question, &run);
        Ok(run)
    })
}

/// What `work` makes of each item, up to an interruption.
///
/// # Errors
/// As `work`, and an interruption before anything was done.
pub fn until_interrupted<T, R>(
    items: &[T],
    mut work: impl FnMut(&T) -> Result<R, TrialError>,
) -> Result<Vec<R>, TrialError> {
    let mut done = Vec::new();
    for item in items {
        match work(item) {
            Ok(own) => done.push(own),
            Err(TrialError::Interrupted) if !done.is_empty() => break,
            Err(error) => return Err(error),
        }
    }
    Ok(done)
}

/// The questions of labelled recordings, with the effects `without` removed from every catalogue.
pub fn questions(labels: &Labels, without: &[String]) -> Vec<Question> {
    let question = |(name, label): (&String, &crate::label::Label)| Question {
        name: name.clone(),
        model: label.robot_toml.clone(),
        without: [without, label.without.as_slice()].concat(),
    };
    labels.iter().map(question).collect()
}

/// Scores the answers to `questions` by the labels.
pub fn score(
    labels: &Labels,
    questions: &[Question],
    answers: Vec<DiagnosisRun>,
) -> Vec<ScoredCase> {
    let both = questions.iter().zip(answers);
    let entry = |(question, run): (&Question, DiagnosisRun)| {
        let label = labels.get(&question.name)?;
        Some(ScoredCase {
            case: question.name.clone(),
            kind: label.kind.clone(),
            score: match run.answer {
                Ok(answer) => grade(label, &answer),
                Err(why) => no_answer(label, why, run.refused),
            },
            label: label.clone(),
            seconds: Some(run.seconds),
        })
    };
    both.filter_map(entry).collect()
}
