//! Leftovers of dead runs: runs whose lock no process holds any more.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;

use rustix::fs::{CWD, FlockOperation, Mode, OFlags, flock, openat};
use rustix::io::Errno;

use super::directory::{LOCK_FILE, LOCK_PREFIX, NAME_PREFIX, SHARED_MEMORY, remove_path};

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
    let me = rustix::process::geteuid().as_raw();
    let mut runs: BTreeMap<(String, bool), Vec<PathBuf>> = BTreeMap::new();
    for entry in fs::read_dir(SHARED_MEMORY)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        // The metadata of the entry itself: no link is followed.
        let (Some(identity), Ok(metadata)) = (identity(&name), entry.metadata()) else {
            continue;
        };
        // What another user put beside the files of a run is listed apart from them.
        let foreign = metadata.uid() != me && me != 0;
        let paths = runs.entry((identity.to_owned(), foreign)).or_default();
        paths.push(entry.path());
    }
    let leftover = |((identity, foreign), paths): ((String, bool), Vec<PathBuf>)| {
        (foreign || is_dead(&identity)).then_some(Leftover { paths, foreign })
    };
    Ok(runs.into_iter().filter_map(leftover).collect())
}

/// The identity in the name of a file of a run; `None` for other files.
fn identity(name: &str) -> Option<&str> {
    let name = name.strip_prefix(LOCK_PREFIX).unwrap_or(name);
    name.strip_prefix(NAME_PREFIX)?.split('_').next()
}

impl Leftover {
    /// Removes the files.
    ///
    /// # Errors
    /// A file cannot be removed; the others are removed.
    pub fn remove(&self) -> io::Result<()> {
        let removed = self.paths.iter().map(|path| remove_path(path));
        removed.fold(Ok(()), io::Result::and)
    }
}

/// Whether no process holds the lock of the run.
fn is_dead(identity: &str) -> bool {
    let run = format!("{NAME_PREFIX}{identity}");
    // In the order in which the lock moves: it is found at one of the places.
    !is_locked(&[&format!("{LOCK_PREFIX}{run}")]) && !is_locked(&[&run, LOCK_FILE])
}

/// Whether a process holds a lock of this file of the shared memory, given by the names on the way
/// to it. Neither links nor pipes, which another user may have put there, are opened.
fn is_locked(names: &[&str]) -> bool {
    let flags = OFlags::CLOEXEC | OFlags::NONBLOCK;
    let shared_memory = openat(CWD, SHARED_MEMORY, flags | OFlags::DIRECTORY, Mode::empty());
    let opened = names.iter().try_fold(shared_memory, |folder, &name| {
        let inside = openat(folder?, name, flags | OFlags::NOFOLLOW, Mode::empty());
        inside.map(Ok)
    });
    opened.flatten().is_ok_and(|file| {
        flock(&file, FlockOperation::NonBlockingLockExclusive) == Err(Errno::WOULDBLOCK)
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

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

    #[test]
    fn a_run_that_died_while_its_folder_was_made_is_left_over() {
        let run = format!("{NAME_PREFIX}{:08x}", 0xe000_0000 | std::process::id());
        let shared_memory = Path::new(SHARED_MEMORY);
        fs::write(shared_memory.join(format!("{LOCK_PREFIX}{run}")), "").unwrap();
        fs::create_dir(shared_memory.join(&run)).unwrap();
        let left = of_run(0xe000_0000 | std::process::id());
        assert_eq!(left.len(), 1);
        assert_eq!(left[0].paths.len(), 2);
        left[0].remove().unwrap();
    }

    #[test]
    fn a_pipe_and_a_link_in_place_of_the_lock_are_not_opened() {
        let identity = 0xd000_0000 | std::process::id();
        let folder = Path::new(SHARED_MEMORY).join(format!("{NAME_PREFIX}{identity:08x}"));
        fs::create_dir(&folder).unwrap();
        let lock = folder.join(LOCK_FILE);
        let pipe = rustix::fs::FileType::Fifo;
        rustix::fs::mknodat(CWD, &lock, pipe, Mode::RWXU, 0).unwrap();
        assert_eq!(
            of_run(identity).len(),
            1,
            "this line would wait for a writer"
        );
        fs::remove_file(&lock).unwrap();
        let target = tempfile::NamedTempFile::new().unwrap();
        target.as_file().lock().unwrap();
        std::os::unix::fs::symlink(target.path(), &lock).unwrap();
        let left = of_run(identity);
        assert_eq!(left.len(), 1, "the lock of another file does not count");
        left[0].remove().unwrap();
        assert!(target.path().exists());
    }
}
