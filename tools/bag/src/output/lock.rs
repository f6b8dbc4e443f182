//! The recording of a run: it grows under its name, locked.

use std::fs::{File, TryLockError};
use std::io;
use std::os::unix::fs::FileExt as _;
use std::path::Path;

use super::beside::Beside;
use crate::error::{Result, write_error};

/// Begins the recording of a run: a file with the bytes `begun` that is locked until it and its
/// duplicates are closed. Its cursor is at 0, for a writer that writes the same bytes first. At no
/// time is there a file under the name that is not a recording.
///
/// # Errors
/// [`Error::Write`](crate::Error::Write): it cannot be opened or written, or another run is recording to it.
pub fn lock_recording(path: &Path, begun: &[u8]) -> Result<File> {
    let create = || match create_recording(path, begun) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => reuse_recording(path, begun),
        other => other,
    };
    create().map_err(write_error(path))
}

/// Creates a file that gets its name when it is locked and has content.
fn create_recording(path: &Path, begun: &[u8]) -> io::Result<File> {
    if path.symlink_metadata().is_ok() {
        return Err(io::ErrorKind::AlreadyExists.into());
    }
    let (file, beside) = Beside::file(path)?;
    lock(file.try_lock())?;
    file.write_all_at(begun, 0)?;
    match std::fs::hard_link(&beside.path, path) {
        // A file system without links.
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            std::fs::rename(&beside.path, path)?;
        }
        linked => linked?,
    }
    Ok(file)
}

/// Opens an earlier recording, which the new one replaces, or a device.
fn reuse_recording(path: &Path, begun: &[u8]) -> io::Result<File> {
    let file = File::options().read(true).write(true).open(path)?;
    if file.metadata()?.is_file() {
        lock(file.try_lock())?;
        file.write_all_at(begun, 0)?;
        file.set_len(begun.len() as u64)?;
    }
    Ok(file)
}

/// Refuses to replace a recording that is being made.
pub(super) fn refuse_recording_in_progress(path: &Path) -> io::Result<()> {
    match File::open(path) {
        Ok(file) => lock(file.try_lock_shared()),
        // It does not exist yet, or its owner alone may read it.
        Err(_) => Ok(()),
    }
}

fn lock(result: std::result::Result<(), TryLockError>) -> io::Result<()> {
    match result {
        Err(TryLockError::WouldBlock) => Err(io::Error::new(
            io::ErrorKind::ResourceBusy,
            "another run is recording to it",
        )),
        // The file system knows no locks.
        Err(TryLockError::Error(_)) | Ok(()) => Ok(()),
    }
}
