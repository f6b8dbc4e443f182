//! Errors: input that cannot be used, and output that cannot be written.

use std::fmt;
use std::path::{Path, PathBuf};

/// Why a recording or a model could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The input is invalid or unreadable; the user has to correct it.
    #[error(transparent)]
    Input(#[from] Unusable),
    /// The operating system did not write a file or folder.
    #[error("{}: {source}; check the path and the free space", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The MCAP library failed to write.
    #[error("{}: {message}; check the path and the free space", path.display())]
    WriteMcap {
        /// The file.
        path: PathBuf,
        /// The error of the library.
        message: String,
    },
}

/// Result of reading or writing a recording or a model.
pub type Result<T> = std::result::Result<T, Error>;

/// Invalid or unreadable input. Prints as one line: file, line number if known, problem, remedy.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct Unusable {
    /// The file or folder.
    pub path: PathBuf,
    /// The line of a text file, counted from 1.
    pub line: Option<u64>,
    /// What is wrong.
    pub problem: String,
    /// How to correct it.
    pub remedy: String,
}

impl Unusable {
    /// An error about a file as a whole.
    pub fn new(path: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            line: None,
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// The same error at a line, counted from 1.
    #[must_use]
    pub fn at(mut self, line: u64) -> Self {
        self.line = Some(line);
        self
    }

    /// An error about a file that the operating system did not read.
    pub fn unreadable(path: &Path, source: &std::io::Error) -> Self {
        Self::new(
            path,
            source.to_string(),
            "check the path and its permissions",
        )
    }
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        // The problem may quote the file, which may hold control characters; an error is one line.
        let one_line = |text: &str| text.replace(|c: char| c.is_control(), " ");
        write!(
            f,
            ": {}; {}",
            one_line(&self.problem),
            one_line(&self.remedy)
        )
    }
}

/// Converts an I/O error into [`Error::Write`] for `path`.
pub(crate) fn write_error(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::Write { path, source }
}
