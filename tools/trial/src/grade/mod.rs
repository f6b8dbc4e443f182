//! Grades one answer against one label.

mod flags;
mod grader;
mod score;
#[cfg(test)]
mod tests;

pub use grader::{grade, no_answer};
pub use score::{AnswerFlag, CaseScore, ParameterScore, TrialGrade};
