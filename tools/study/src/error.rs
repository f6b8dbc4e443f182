//! Why a study could not be done.

use slipstream_bus::InputError;
use slipstream_launch::RunError;

/// Why a study could not be done.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The request or its experiment is invalid.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A run with programs failed, for this reason.
    #[error("{0}")]
    Failed(String),
    /// The threads could not be started.
    #[error("the threads of the study could not be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
