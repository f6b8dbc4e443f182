//! Sealed trials of the diagnosis: cases made, concealed, diagnosed, opened and scored.

pub mod answer;
pub mod examine;
pub mod folder;
pub mod hold;
mod intervals;
pub mod label;
pub mod maker;
pub mod mark;
pub mod page;
mod parallel;
pub mod plant;
pub mod seal;
pub mod tally;

/// Why a trial could not be held.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// What was given cannot be used: place, problem and remedy in one line.
    #[error("{place}: {problem}; {remedy}")]
    Unusable {
        /// File, line or argument.
        place: String,
        /// What is wrong.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
    /// The system would not do what it was asked.
    #[error("{place}: {source}")]
    System {
        /// File or program.
        place: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// Somebody interrupted the trial.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

impl TrialError {
    pub(crate) fn unusable(
        place: impl std::fmt::Display,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        let one_line = |text: String| text.replace(|c: char| c.is_control(), " ");
        Self::Unusable {
            place: place.to_string(),
            problem: one_line(problem.into()),
            remedy: one_line(remedy.into()),
        }
    }

    pub(crate) fn system(
        place: impl std::fmt::Display,
    ) -> impl FnOnce(std::io::Error) -> TrialError {
        let place = place.to_string();
        move |source| Self::System { place, source }
    }
}
