//! Exit codes (CONTRACT.md, section 5), in one place.

use std::process::ExitCode;

use slipstream_launch::{LaunchError, RunError, Unusable};
use slipstream_recording::Error as RecordingError;
use slipstream_study::StudyError;
use slipstream_trial::TrialError;

/// How the program ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exit {
    /// The work is done.
    Done,
    /// The work failed.
    Failed,
    /// The input cannot be used.
    Unusable,
    /// Somebody interrupted it.
    Interrupted,
}

impl Exit {
    /// The number that the shell sees.
    pub(crate) fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Failed => 1,
            Self::Unusable => 2,
            Self::Interrupted => 130,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        exit.code().into()
    }
}

/// Why a command did not do its work; one line for the user.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// The input cannot be used.
    #[error(transparent)]
    Unusable(#[from] Unusable),
    /// A file or argument cannot be used.
    #[error("{0}")]
    Input(String),
    /// The processes of a run could not be started.
    #[error(transparent)]
    Launch(LaunchError),
    /// The work failed.
    #[error("{0}")]
    Failed(String),
    /// Somebody interrupted the work.
    #[error("{0}")]
    Interrupted(String),
}

impl From<LaunchError> for Error {
    fn from(error: LaunchError) -> Self {
        match error {
            LaunchError::Unusable(unusable) => Self::Unusable(unusable),
            other => Self::Launch(other),
        }
    }
}

impl From<RunError> for Error {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Model(model) => {
                Self::Unusable(Unusable::new(model.key, model.problem, model.remedy))
            }
            RunError::Unusable(unusable) => Self::Unusable(unusable),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<StudyError> for Error {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Unusable(unusable) => Self::Unusable(unusable),
            StudyError::Run(run) => run.into(),
            StudyError::Picture(_) | StudyError::Threads(_) => Self::Failed(error.to_string()),
        }
    }
}

impl From<TrialError> for Error {
    fn from(error: TrialError) -> Self {
        match error {
            TrialError::Unusable { .. } => Self::Input(error.to_string()),
            TrialError::System { .. } => Self::Failed(error.to_string()),
            TrialError::Interrupted => Self::Interrupted(error.to_string()),
        }
    }
}

impl From<RecordingError> for Error {
    fn from(error: RecordingError) -> Self {
        match error {
            RecordingError::Input(unusable) => Self::Input(unusable.to_string()),
            RecordingError::Write { .. } | RecordingError::WriteMcap { .. } => {
                Self::Failed(error.to_string())
            }
        }
    }
}

impl Error {
    /// The exit code of this error.
    pub(crate) fn exit(&self) -> Exit {
        match self {
            Self::Unusable(_) | Self::Input(_) => Exit::Unusable,
            Self::Launch(_) | Self::Failed(_) => Exit::Failed,
            Self::Interrupted(_) => Exit::Interrupted,
        }
    }
}
