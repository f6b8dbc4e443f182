//! Errors: input that cannot be used, and output that cannot be written.

use std::io;
use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

/// Why a recording or a model could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The input is invalid or unreadable; the user has to correct it.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The operating system did not write a file or folder.
    #[error("{}: cannot be written: {}", path.display(), cause(source))]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
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

impl Error {
    /// Whether the path itself is unusable, so that the user has to give another one. Otherwise
    /// the work failed, as on a full disk.
    pub fn is_unusable_path(&self) -> bool {
        use io::ErrorKind::{
            InvalidFilename, IsADirectory, NotADirectory, NotFound, PermissionDenied,
            ReadOnlyFilesystem, ResourceBusy,
        };
        matches!(self, Self::Write { source, .. } if matches!(
            source.kind(),
            InvalidFilename | IsADirectory | NotADirectory | NotFound | PermissionDenied
                | ReadOnlyFilesystem | ResourceBusy
        ))
    }
}

/// What the operating system refused, and the remedy.
fn cause(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::StorageFull => "no space left; free some, or write elsewhere".to_owned(),
        io::ErrorKind::QuotaExceeded => {
            "no space left within the quota; free some, or write elsewhere".to_owned()
        }
        io::ErrorKind::FileTooLarge => {
            "no space left below the file-size limit; raise it (ulimit -f)".to_owned()
        }
        _ => format!("{error}; give another file"),
    }
}

/// Converts an I/O error into [`Error::Write`] for `path`.
pub fn write_error(path: &Path) -> impl FnOnce(io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::Write { path, source }
}
