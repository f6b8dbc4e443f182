//! Where a run keeps its shared files: names of its own, and a lock that says whether it lives.
//!
//! Everything of a run begins with `/dev/shm/slipstream-<identity>`: a folder with the description,
//! the wake_page page and iceoryx2's own files, and beside it iceoryx2's shared memory. Every process of
//! the run holds a shared lock in the folder until it ends, whatever ends it.

use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};

/// Where shared memory lives.
pub const SHARED_MEMORY: &str = "/dev/shm";
/// What all runs' names begin with.
const BEGINNING: &str = "slipstream-";

/// The place of one run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunDirectory {
    folder: PathBuf,
}

/// Held by every process of a run while it lives.
#[derive(Debug)]
pub struct RunLock {
    _file: File,
}

/// What a run left behind, and whose it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leftover {
    /// Files and folders.
    pub paths: Vec<PathBuf>,
    /// They belong to another user.
    pub foreign: bool,
}

impl RunDirectory {
    /// Makes the place of a new run.
    ///
    /// # Errors
    /// When the system does not let it be made.
    pub fn create(identity: u32) -> io::Result<(Self, RunLock)> {
        let name = format!("{BEGINNING}{identity:08x}");
        // Made under another name, so that nobody sees it without its lock.
        let making = Path::new(SHARED_MEMORY).join(format!("making-{name}"));
        DirBuilder::new().mode(0o700).create(&making)?;
        let folder = Path::new(SHARED_MEMORY).join(name);
        match lock_in(&making).and_then(|alive| fs::rename(&making, &folder).map(|()| alive)) {
            Ok(alive) => Ok((Self { folder }, alive)),
            Err(error) => {
                let _ = fs::remove_dir_all(&making);
                Err(error)
            }
        }
    }

    /// The place in this folder, of a run that lives.
    ///
    /// # Errors
    /// When there is no such run.
    pub fn join(folder: &Path) -> io::Result<(Self, RunLock)> {
        let alive = File::open(folder.join("alive"))?;
        flock(&alive, FlockOperation::NonBlockingLockShared)?;
        Ok((
            Self {
                folder: folder.to_owned(),
            },
            RunLock { _file: alive },
        ))
    }

    /// The run's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The experiment, for the processes.
    pub fn experiment(&self) -> PathBuf {
        self.folder.join("experiment")
    }

    /// The wake_page page.
    pub fn wake_page(&self) -> PathBuf {
        self.folder.join("wake_page")
    }

    /// What every shared-memory segment of the run begins with.
    pub fn prefix(&self) -> String {
        let name = self.folder.file_name().unwrap_or_default();
        format!("{}_", name.to_string_lossy())
    }

    /// Removes everything of the run.
    ///
    /// # Errors
    /// When the system does not let it be removed.
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
fn lock_in(folder: &Path) -> io::Result<RunLock> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true).mode(0o600);
    let file = options.open(folder.join("alive"))?;
    flock(&file, FlockOperation::NonBlockingLockShared)?;
    Ok(RunLock { _file: file })
}

/// What dead runs left behind.
///
/// # Errors
/// When the system does not let shared memory be listed.
pub fn leftovers() -> io::Result<Vec<Leftover>> {
    let me = rustix::process::getuid().as_raw();
    let mut runs: std::collections::BTreeMap<String, Leftover> = std::collections::BTreeMap::new();
    for entry in fs::read_dir(SHARED_MEMORY)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let name = name.strip_prefix("making-").unwrap_or(&name);
        let Some(rest) = name.strip_prefix(BEGINNING) else {
            continue;
        };
        let identity = rest.split('_').next().unwrap_or(rest).to_owned();
        let Ok(metadata) = entry.metadata() else {
            continue;
        };
        let run = runs.entry(identity).or_insert(Leftover {
            paths: Vec::new(),
            foreign: false,
        });
        run.foreign |= metadata.uid() != me && me != 0;
        run.paths.push(entry.path());
    }
    Ok(runs
        .into_values()
        .filter(|run| run.foreign || is_dead(run))
        .collect())
}

impl Leftover {
    /// Removes it.
    ///
    /// # Errors
    /// When the system does not let it be removed.
    pub fn remove(&self) -> io::Result<()> {
        self.paths.iter().try_for_each(|path| remove_path(path))
    }
}

/// Nobody holds the lock of any folder of the run.
fn is_dead(run: &Leftover) -> bool {
    run.paths
        .iter()
        .all(|path| match File::open(path.join("alive")) {
            Ok(file) => flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok(),
            Err(_) => !is_being_made(path),
        })
}

/// A folder younger than this without a lock is a run that is just being made.
const MAKING_S: u64 = 10;

fn is_being_made(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let age = fs::metadata(path)
        .and_then(|m| m.modified())
        .map(|t| t.elapsed());
    name.starts_with("making-") && matches!(age, Ok(Ok(age)) if age.as_secs() < MAKING_S)
}

fn remove_path(path: &Path) -> io::Result<()> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn named(identity: u32) -> impl Fn(&Leftover) -> bool {
        move |run| {
            run.paths
                .iter()
                .any(|path| path.to_string_lossy().contains(&format!("{identity:08x}")))
        }
    }

    #[test]
    fn a_run_is_left_over_when_its_last_process_is_gone() {
        let identity = 0xf000_0000 | std::process::id();
        let (place, alive) = RunDirectory::create(identity).unwrap();
        let segment = Path::new(SHARED_MEMORY).join(format!("{}data", place.prefix()));
        fs::write(&segment, "x").unwrap();
        let (_, second) = RunDirectory::join(place.folder()).unwrap();
        drop(alive);
        assert!(
            !leftovers().unwrap().iter().any(named(identity)),
            "one still lives"
        );
        drop(second);
        let left: Vec<_> = leftovers()
            .unwrap()
            .into_iter()
            .filter(named(identity))
            .collect();
        assert_eq!(left.len(), 1);
        left[0].remove().unwrap();
        assert!(!segment.exists() && !place.folder().exists());
    }
}
