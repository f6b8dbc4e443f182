//! Why a trial failed.

use slipstream_bus::InputError;

/// Why a trial failed.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// An input cannot be used.
    #[error(transparent)]
    Input(#[from] InputError),
    /// An output cannot be written.
    #[error(transparent)]
    Output(#[from] slipstream_recording::Error),
    /// An operation of the operating system failed.
    #[error("{place}: {source}")]
    System {
        /// File or program.
        place: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The user interrupted the trial.
    #[error("interrupted")]
    Interrupted,
}

impl TrialError {
    pub(crate) fn input(
        place: impl std::fmt::Display,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Input(InputError::new(place.to_string(), problem, remedy))
    }

    pub(crate) fn system(place: impl std::fmt::Display) -> impl FnOnce(std::io::Error) -> Self {
        let place = place.to_string();
        move |source| Self::System { place, source }
    }
}
