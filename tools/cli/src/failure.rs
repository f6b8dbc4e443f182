//! How commands fail: one line, and the exit code that says whose turn it is.

use std::process::ExitCode;

use slipstream_recording::Error;

/// Why a command did not do what it was asked.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The work failed (exit code 1).
    Work(String),
    /// The input cannot be used (exit code 2).
    Input(String),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Input(unusable) => Self::Input(unusable.to_string()),
            Error::Write { .. } | Error::WriteMcap { .. } => Self::Work(error.to_string()),
        }
    }
}

/// Says why, and maps the outcome to the exit code: 0 done, 1 work failed, 2 unusable input.
pub(crate) fn exit_code(done: Result<(), Failure>) -> ExitCode {
    let (why, code) = match done {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Work(why)) => (why, 1),
        Err(Failure::Input(why)) => (why, 2),
    };
    eprintln!("slipstream: {why}");
    ExitCode::from(code)
}
