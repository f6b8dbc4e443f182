//! Exit codes: 0 done, 1 failed, 2 invalid input, 3 and 4 by the verdict where asked, 130 interrupted by a signal.

use std::process::ExitCode;

use slipstream_bus::InputError;
use slipstream_launch::{LaunchError, RunError};
use slipstream_recording::Error as RecordingError;
use slipstream_study::StudyError;
use slipstream_trial::TrialError;

/// How the program ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exit {
    /// The command did its work.
    Done,
    /// The command failed.
    Failed,
    /// The input cannot be used.
    InvalidInput,
    /// The answer is explained, where the exit code was asked to say so.
    Explained,
    /// The answer is unexplained, likewise.
    Unexplained,
    /// A signal interrupted the command.
    Interrupted,
}

impl Exit {
    /// The exit code of the process.
    pub(crate) fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Failed => 1,
            Self::InvalidInput => 2,
            Self::Explained => 3,
            Self::Unexplained => 4,
            Self::Interrupted => 130,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        exit.code().into()
    }
}

/// Why a command failed, as one line.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// The input cannot be used.
    #[error(transparent)]
    Input(#[from] InputError),
    /// An output path cannot be used.
    #[error("{0}")]
    UnusableOutput(String),
    /// The command failed.
    #[error("{0}")]
    Failed(String),
    /// A signal interrupted the command.
    #[error("{0}")]
    Interrupted(String),
}

impl From<LaunchError> for Error {
    fn from(error: LaunchError) -> Self {
        match error {
            LaunchError::Input(error) => Self::Input(error),
            LaunchError::Recording(error) => error.into(),
            other @ LaunchError::System { .. } => Self::Failed(other.to_string()),
        }
    }
}

impl From<RunError> for Error {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Input(error) => Self::Input(error),
            RunError::Recording(error) => error.into(),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<StudyError> for Error {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Input(error) => Self::Input(error),
            StudyError::Run(run) => run.into(),
            StudyError::Threads(_) | StudyError::Failed(_) => Self::Failed(error.to_string()),
        }
    }
}

impl From<TrialError> for Error {
    fn from(error: TrialError) -> Self {
        match error {
            TrialError::Input(error) => Self::Input(error),
            TrialError::Output(error) => error.into(),
            TrialError::System { .. } => Self::Failed(error.to_string()),
            TrialError::Interrupted => Self::Interrupted(error.to_string()),
        }
    }
}

impl From<RecordingError> for Error {
    fn from(error: RecordingError) -> Self {
        match error {
            RecordingError::Input(error) => Self::Input(error),
            unusable if unusable.is_unusable_path() => Self::UnusableOutput(unusable.to_string()),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl Error {
    /// The same error, with the argument that gave the path of an output.
    pub(crate) fn of_argument(self, argument: &str) -> Self {
        match self {
            Self::UnusableOutput(error) => Self::UnusableOutput(format!("{argument} {error}")),
            other => other,
        }
    }

    /// The exit code of this error.
    pub(crate) fn exit(&self) -> Exit {
        match self {
            Self::Input(_) | Self::UnusableOutput(_) => Exit::InvalidInput,
            Self::Failed(_) => Exit::Failed,
            Self::Interrupted(_) => Exit::Interrupted,
        }
    }
}
