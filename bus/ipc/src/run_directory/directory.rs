//! The directory of a live run: creation, joining, paths, removal.

use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};

/// Folder of POSIX shared memory.
pub const SHARED_MEMORY: &str = "/dev/shm";
/// Begin of the names of all runs.
pub(super) const NAME_PREFIX: &str = "slipstream-";
/// Begin of the name of the lock of a run whose folder does not exist yet.
pub(super) const LOCK_PREFIX: &str = "lock-";
/// Name of the lock file in the folder.
pub(super) const LOCK_FILE: &str = "alive";

/// Largest number of times that the shared memory is listed to remove the files of a run.
const LISTINGS: u32 = 5;

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
        // The lock comes first and moves into the folder: at no time is there a folder of a live
        // run whose lock is not held.
        let outside = Path::new(SHARED_MEMORY).join(format!("{LOCK_PREFIX}{name}"));
        let folder = Path::new(SHARED_MEMORY).join(name);
        let lock = create_lock(&outside)?;
        let created = DirBuilder::new()
            .mode(0o700)
            .create(&folder)
            .and_then(|()| fs::rename(&outside, folder.join(LOCK_FILE)));
        match created {
            Ok(()) => Ok((Self { folder }, lock)),
            Err(error) => {
                let _ = fs::remove_file(&outside);
                // Fails if the folder is that of another run, which is not empty.
                let _ = fs::remove_dir(&folder);
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

    /// Removes the folder and all shared memory segments of the run. Files that another user put
    /// beside them stay.
    ///
    /// # Errors
    /// A file of this user cannot be removed; the others are removed.
    pub fn remove(&self) -> io::Result<()> {
        let mut result = remove_path(&self.folder);
        // Other runs create and remove files while this folder is listed, and a listing may miss one.
        for _ in 0..LISTINGS {
            let mut own = self.segments()?;
            own.retain(|path| is_own(path));
            if own.is_empty() {
                break;
            }
            for path in own {
                result = result.and(remove_path(&path));
            }
        }
        result
    }

    /// Files with the names of this run's shared memory that belong to another user, who may have
    /// put them there to disturb it.
    ///
    /// # Errors
    /// The shared memory cannot be listed.
    pub fn planted(&self) -> io::Result<Vec<PathBuf>> {
        let mut paths = self.segments()?;
        paths.retain(|path| !is_own(path));
        Ok(paths)
    }

    /// Takes from other users what the library grants them on the shared memory of the run: iceoryx2
    /// makes the file that counts its nodes writable by everybody.
    ///
    /// # Errors
    /// The shared memory cannot be listed.
    pub(crate) fn close_to_others(&self) -> io::Result<()> {
        for path in self.segments()? {
            let open = fs::symlink_metadata(&path).is_ok_and(|metadata| {
                metadata.is_file() && metadata.permissions().mode() & 0o077 != 0
            });
            if open && is_own(&path) {
                // It may have been removed just now.
                let _ = fs::set_permissions(&path, fs::Permissions::from_mode(0o600));
            }
        }
        Ok(())
    }

    fn segments(&self) -> io::Result<Vec<PathBuf>> {
        let prefix = self.prefix();
        let mut paths = Vec::new();
        for entry in fs::read_dir(SHARED_MEMORY)? {
            let entry = entry?;
            if entry.file_name().to_string_lossy().starts_with(&prefix) {
                paths.push(entry.path());
            }
        }
        Ok(paths)
    }
}

/// Whether a path itself, not what a link points to, belongs to the user of this process. One that
/// has vanished does.
fn is_own(path: &Path) -> bool {
    let user = rustix::process::geteuid().as_raw();
    fs::symlink_metadata(path).map_or(true, |metadata| metadata.uid() == user)
}

/// Creates the lock of a new run and takes it.
fn create_lock(path: &Path) -> io::Result<RunLock> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true).mode(0o600);
    let file = options.open(path)?;
    flock(&file, FlockOperation::NonBlockingLockShared)?;
    if file.metadata()?.nlink() == 0 {
        // Another process took it for a leftover before it was locked.
        return Err(io::Error::other(
            "was removed by another process; try again",
        ));
    }
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
