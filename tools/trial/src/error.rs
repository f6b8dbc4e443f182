//! Why a trial failed.

/// Why a trial failed.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// An input is invalid: place, problem and remedy in one line.
    #[error("{place}: {problem}; {remedy}")]
    Unusable {
        /// File, line or argument.
        place: String,
        /// What is wrong.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
    /// An operation of the operating system failed.
    #[error("{place}: {source}")]
    System {
        /// File or program.
        place: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The user interrupted the trial.
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

    pub(crate) fn system(place: impl std::fmt::Display) -> impl FnOnce(std::io::Error) -> Self {
        let place = place.to_string();
        move |source| Self::System { place, source }
    }
}
