//! What can go wrong: input that cannot be used, and output that cannot be written.

use std::fmt;
use std::path::{Path, PathBuf};

/// Why a recording or a model could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The input is not what it should be: for the user to mend.
    #[error(transparent)]
    Input(#[from] Unusable),
    /// The system would not let a file be written.
    #[error("{}: {source}; check the place and the space left there", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The MCAP library would not write.
    #[error("{}: {message}; check the place and the space left there", path.display())]
    WriteMcap {
        /// The file.
        path: PathBuf,
        /// What the library said.
        message: String,
    },
}

/// A result of this room.
pub type Result<T> = std::result::Result<T, Error>;

/// Input that cannot be used, in one line: file, line where there is one, what is wrong, what to
/// do about it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct Unusable {
    /// The file or folder.
    pub path: PathBuf,
    /// The line, counted from 1, in a text file.
    pub line: Option<u64>,
    /// What is wrong.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
}

impl Unusable {
    /// An error about a whole file.
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

    /// A file that the system would not let be read.
    pub fn unreadable(path: &Path, source: &std::io::Error) -> Self {
        Self::new(path, source.to_string(), "check the name and its rights")
    }
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        // What a file says may hold anything: an error is one line all the same.
        let one_line = |text: &str| text.replace(|c: char| c.is_control(), " ");
        write!(
            f,
            ": {}; {}",
            one_line(&self.problem),
            one_line(&self.remedy)
        )
    }
}

/// Maps a failure of the system to a failure to write `path`.
pub(crate) fn writing(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::Write { path, source }
}
