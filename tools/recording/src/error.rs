//! Errors: input that cannot be used, and output that cannot be written.

use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

/// Why a recording or a model could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The input is invalid or unreadable; the user has to correct it.
    #[error(transparent)]
    Input(#[from] InputError),
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

/// Converts an I/O error into [`Error::Write`] for `path`.
pub(crate) fn write_error(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::Write { path, source }
}
