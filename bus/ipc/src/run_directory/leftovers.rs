//! Leftovers of dead runs: runs whose lock no process holds any more.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};

use super::directory::{INCOMPLETE_PREFIX, LOCK_FILE, NAME_PREFIX, SHARED_MEMORY, remove_path};

/// An incomplete folder younger than this belongs to a run that is being created (s).
const CREATION_S: u64 = 10;

/// The files that one run left behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leftover {
    /// Files and folders.
    pub paths: Vec<PathBuf>,
    /// Whether they belong to another user. Such a run is listed even if it is alive.
    pub foreign: bool,
}

/// Lists what dead runs left behind, and the runs of other users.
///
/// # Errors
/// The shared memory cannot be listed.
pub fn leftovers() -> io::Result<Vec<Leftover>> {
    let me = rustix::process::getuid().as_raw();
    let mut runs: BTreeMap<String, Leftover> = BTreeMap::new();
    for entry in fs::read_dir(SHARED_MEMORY)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let name = name.strip_prefix(INCOMPLETE_PREFIX).unwrap_or(&name);
        let Some(rest) = name.strip_prefix(NAME_PREFIX) else {
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
    /// Removes the files.
    ///
    /// # Errors
    /// A file cannot be removed.
    pub fn remove(&self) -> io::Result<()> {
        self.paths.iter().try_for_each(|path| remove_path(path))
    }
}

/// Whether no process holds the lock of a folder of the run.
fn is_dead(run: &Leftover) -> bool {
    run.paths
        .iter()
        .all(|path| match File::open(path.join(LOCK_FILE)) {
            Ok(file) => flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok(),
            Err(_) => !is_being_created(path),
        })
}

fn is_being_created(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let age = fs::metadata(path)
        .and_then(|metadata| metadata.modified())
        .map(|modified| modified.elapsed());
    name.starts_with(INCOMPLETE_PREFIX) && matches!(age, Ok(Ok(age)) if age.as_secs() < CREATION_S)
}

#[cfg(test)]
mod tests {
    use super::super::directory::RunDirectory;
    use super::*;

    fn of_run(identity: u32) -> Vec<Leftover> {
        let identity = format!("{identity:08x}");
        let contains = |path: &PathBuf| path.to_string_lossy().contains(&identity);
        let mut runs = leftovers().unwrap();
        runs.retain(|run| run.paths.iter().any(contains));
        runs
    }

    #[test]
    fn a_run_is_left_over_once_its_last_process_is_gone() {
        let identity = 0xf000_0000 | std::process::id();
        let (directory, lock) = RunDirectory::create(identity).unwrap();
        let segment = Path::new(SHARED_MEMORY).join(format!("{}data", directory.prefix()));
        fs::write(&segment, "x").unwrap();
        let (_, second_lock) = RunDirectory::join(directory.folder()).unwrap();
        drop(lock);
        assert!(of_run(identity).is_empty(), "one process still lives");
        drop(second_lock);
        let left = of_run(identity);
        assert_eq!(left.len(), 1);
        left[0].remove().unwrap();
        assert!(!segment.exists() && !directory.folder().exists());
    }
}
