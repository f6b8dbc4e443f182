//! Files and folders that are not whole yet: they stand beside their later name, and vanish if they do not
//! get it.

use std::collections::BTreeSet;
use std::fs::File;
use std::io;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Begin of the names of files that are not whole yet.
const PREFIX: &str = ".slipstream-";

/// Number of files that were begun.
static FILES: AtomicU64 = AtomicU64::new(0);
/// Files of this process that are not whole yet.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The name of a file or folder that is not whole yet. Dropped, it vanishes.
#[derive(Debug)]
pub(super) struct Beside {
    pub(super) path: PathBuf,
}

impl Beside {
    /// Creates a file or folder in the folder of `target`.
    pub(super) fn create<T>(
        target: &Path,
        create: impl Fn(&Path) -> io::Result<T>,
    ) -> io::Result<(T, Self)> {
        let folder = folder(target);
        loop {
            let number = FILES.fetch_add(1, Ordering::Relaxed);
            let path = folder.join(format!("{PREFIX}{}-{number}", std::process::id()));
            match create(&path) {
                // Left by a process that was killed.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                created => {
                    let created = created?;
                    unfinished(|paths| paths.insert(path.clone()));
                    return Ok((created, Self { path }));
                }
            }
        }
    }

    /// Creates a file.
    pub(super) fn file(target: &Path) -> io::Result<(File, Self)> {
        let mut options = File::options();
        options.read(true).write(true).create_new(true);
        Self::create(target, |path| options.open(path))
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        unfinished(|paths| paths.remove(&self.path));
        remove(&self.path);
    }
}

/// Removes a file or folder, which may have got its final name.
fn remove(path: &Path) {
    let _ = std::fs::remove_file(path).or_else(|_| std::fs::remove_dir_all(path));
}

/// Removes the files of this process that are not whole yet. For a process that ends without
/// dropping them, after a signal.
pub fn remove_unfinished() {
    unfinished(|paths| {
        std::mem::take(paths).iter().for_each(|path| remove(path));
    });
}

fn unfinished<T>(access: impl FnOnce(&mut BTreeSet<PathBuf>) -> T) -> T {
    access(&mut UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner))
}

/// The name of a temporary file. Dropped, it vanishes; who has the file open can still use it.
#[derive(Debug)]
pub(crate) struct TemporaryName(Beside);

impl TemporaryName {
    /// The path of the file.
    pub(crate) fn path(&self) -> &Path {
        &self.0.path
    }
}

/// A temporary file, which only this user may read.
pub(crate) fn temporary_file() -> io::Result<(File, TemporaryName)> {
    let mut options = File::options();
    options.read(true).write(true).create_new(true).mode(0o600);
    let any = std::env::temp_dir().join("any");
    let (file, name) = Beside::create(&any, |path| options.open(path))?;
    Ok((file, TemporaryName(name)))
}

/// A temporary file without a name, which vanishes with the process.
///
/// # Errors
/// If the operating system does not create it.
pub fn unnamed_file() -> io::Result<File> {
    temporary_file().map(|(file, _)| file)
}

/// The folder of a file.
pub(super) fn folder(path: &Path) -> PathBuf {
    let parent = path
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty());
    parent.map_or_else(|| PathBuf::from("."), Path::to_owned)
}

/// Names of the files in a folder, for tests.
#[cfg(test)]
pub(super) fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.collect()
}
