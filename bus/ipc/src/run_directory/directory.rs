//! The directory of a live run: creation, joining, paths, removal.

use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};

/// Folder of POSIX shared memory.
pub const SHARED_MEMORY: &str = "/dev/shm";
/// Begin of the names of all runs.
pub(super) const NAME_PREFIX: &str = "slipstream-";
/// Begin of the name of a folder that is not complete yet.
pub(super) const INCOMPLETE_PREFIX: &str = "making-";
/// Name of the lock file in the folder.
pub(super) const LOCK_FILE: &str = "alive";

/// The directory of one run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunDirectory {
    folder: PathBuf,
}

/// The lock that every process of a run holds while it lives.
#[derive(Debug)]
pub struct RunLock {
    _file: File,
}

impl RunDirectory {
    /// Creates the directory of a new run.
    ///
    /// # Errors
    /// The folder or its lock cannot be created.
    pub fn create(identity: u32) -> io::Result<(Self, RunLock)> {
        let name = format!("{NAME_PREFIX}{identity:08x}");
        // Created under another name and renamed when it has its lock: nobody sees it without one.
        let incomplete = Path::new(SHARED_MEMORY).join(format!("{INCOMPLETE_PREFIX}{name}"));
        DirBuilder::new().mode(0o700).create(&incomplete)?;
        let folder = Path::new(SHARED_MEMORY).join(name);
        let locked = create_lock(&incomplete)
            .and_then(|lock| fs::rename(&incomplete, &folder).map(|()| lock));
        match locked {
            Ok(lock) => Ok((Self { folder }, lock)),
            Err(error) => {
                let _ = fs::remove_dir_all(&incomplete);
                Err(error)
            }
        }
    }

    /// Opens the directory of a live run.
    ///
    /// # Errors
    /// The folder does not exist, or its run is being removed.
    pub fn join(folder: &Path) -> io::Result<(Self, RunLock)> {
        let file = File::open(folder.join(LOCK_FILE))?;
        flock(&file, FlockOperation::NonBlockingLockShared)?;
        let folder = folder.to_owned();
        Ok((Self { folder }, RunLock { _file: file }))
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Path of the experiment, encoded for the processes.
    pub fn experiment(&self) -> PathBuf {
        self.folder.join("experiment")
    }

    /// Path of the wake-up page.
    pub fn wake_page(&self) -> PathBuf {
        self.folder.join("wake_page")
    }

    /// Begin of the names of all shared memory segments of the run.
    pub fn prefix(&self) -> String {
        let name = self.folder.file_name().unwrap_or_default();
        format!("{}_", name.to_string_lossy())
    }

    /// Removes the folder and all shared memory segments of the run.
    ///
    /// # Errors
    /// A file cannot be removed.
    pub fn remove(&self) -> io::Result<()> {
        let prefix = self.prefix();
        for entry in fs::read_dir(SHARED_MEMORY)? {
            let entry = entry?;
            if entry.file_name().to_string_lossy().starts_with(&prefix) {
                remove_path(&entry.path())?;
            }
        }
        remove_path(&self.folder)
    }
}

/// Creates the lock of a new run and takes it.
fn create_lock(folder: &Path) -> io::Result<RunLock> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true).mode(0o600);
    let file = options.open(folder.join(LOCK_FILE))?;
    flock(&file, FlockOperation::NonBlockingLockShared)?;
    Ok(RunLock { _file: file })
}

/// Removes a file or a folder. One that does not exist is no error.
pub(super) fn remove_path(path: &Path) -> io::Result<()> {
    let removed = match fs::symlink_metadata(path) {
        Ok(metadata) if metadata.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
        Err(error) => Err(error),
    };
    match removed {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}
