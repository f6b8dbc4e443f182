//! Output files: written beside their name and moved there once they are whole.
//!
//! An interruption, a full disk or a second program never leaves part of a file under its final
//! name. The recording of a run is the exception: it grows under its name, so that it can be read
//! if the run dies, and is locked while it grows ([`lock_recording`]).

use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::{FileExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use slipstream_bus::InputError;

use crate::error::{Error, Result, write_error};

/// Begin of the names of files that are not whole yet.
const PREFIX: &str = ".slipstream-";

/// Number of files that were begun.
static FILES: AtomicU64 = AtomicU64::new(0);
/// Files of this process that are not whole yet.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A file that is being written. It gets its name in [`OutputFile::finish`]; dropped before, it
/// vanishes.
#[derive(Debug)]
pub struct OutputFile {
    /// The name, for errors.
    path: PathBuf,
    /// The name without symbolic links.
    target: PathBuf,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    /// A new file beside the target.
    Beside(BufWriter<File>, Beside),
    /// A device or a pipe, such as /dev/stdout.
    Direct(BufWriter<File>),
}

/// Writes a whole file.
///
/// # Errors
/// [`Error::Write`].
pub fn write_file(path: &Path, content: &[u8]) -> Result<()> {
    let mut file = OutputFile::create(path)?;
    file.write_all(content).map_err(write_error(path))?;
    file.finish()
}

impl OutputFile {
    /// Begins a file that will be called `path`.
    ///
    /// # Errors
    /// [`Error::Write`]: the file cannot be created, or a run is recording to it.
    pub fn create(path: &Path) -> Result<Self> {
        Self::begin(path).map_err(write_error(path))
    }

    fn begin(path: &Path) -> io::Result<Self> {
        // follow symbolic links
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let sink = if target.exists() && !target.is_file() {
            Sink::Direct(BufWriter::new(File::options().write(true).open(path)?))
        } else {
            refuse_recording_in_progress(&target)?;
            let (file, beside) = Beside::file(&target)?;
            Sink::Beside(BufWriter::new(file), beside)
        };
        Ok(Self {
            path: path.to_owned(),
            target,
            sink,
        })
    }

    /// Writes what is buffered and gives the file its name.
    ///
    /// # Errors
    /// [`Error::Write`]; the file vanishes.
    pub fn finish(mut self) -> Result<()> {
        self.persist().map_err(write_error(&self.path))
    }

    fn persist(&mut self) -> io::Result<()> {
        self.flush()?;
        if let Sink::Beside(_, beside) = &self.sink {
            refuse_recording_in_progress(&self.target)?;
            std::fs::rename(&beside.path, &self.target)?;
        }
        Ok(())
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.sink {
            Sink::Beside(file, _) => file.write(bytes),
            Sink::Direct(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Beside(file, _) => file.flush(),
            Sink::Direct(file) => file.flush(),
        }
    }
}

/// A folder that is being written. It gets its name in [`OutputFolder::finish`], or, if an empty folder
/// has that name, its files do; dropped before, it vanishes with its files.
#[derive(Debug)]
pub struct OutputFolder {
    target: PathBuf,
    beside: Beside,
    /// The target exists. The new folder is inside of it, since only there it is sure that files can be
    /// created and renamed.
    inside: bool,
}

impl OutputFolder {
    /// Begins a folder that will be called `path`. An empty folder of that name may exist.
    ///
    /// # Errors
    /// [`Error::Write`]: the folder cannot be created; [`Error::Input`]: the existing one is not empty.
    pub fn create(path: &Path) -> Result<Self> {
        let begin = || -> io::Result<Self> {
            let inside = path.is_dir();
            let beside = if inside {
                path.join("any")
            } else {
                std::fs::create_dir_all(folder(path))?;
                path.to_owned()
            };
            let ((), beside) = Beside::create(&beside, |path| std::fs::create_dir(path))?;
            let target = path.to_owned();
            Ok(Self {
                target,
                beside,
                inside,
            })
        };
        if std::fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_some()) {
            let problem = "the folder is not empty";
            return Err(InputError::file(path, problem, "give a new folder").into());
        }
        begin().map_err(write_error(path))
    }

    /// Where the files of the folder are written.
    pub fn path(&self) -> &Path {
        &self.beside.path
    }

    /// Gives the folder its name.
    ///
    /// # Errors
    /// [`Error::Write`]; the folder vanishes.
    pub fn finish(self) -> Result<()> {
        self.persist().map_err(write_error(&self.target))
    }

    fn persist(&self) -> io::Result<()> {
        if !self.inside {
            return std::fs::rename(self.path(), &self.target);
        }
        for entry in std::fs::read_dir(self.path())? {
            let entry = entry?;
            std::fs::rename(entry.path(), self.target.join(entry.file_name()))?;
        }
        Ok(())
    }
}

/// The name of a file or folder that is not whole yet. Dropped, it vanishes.
#[derive(Debug)]
struct Beside {
    path: PathBuf,
}

impl Beside {
    /// Creates a file or folder in the folder of `target`.
    fn create<T>(target: &Path, create: impl Fn(&Path) -> io::Result<T>) -> io::Result<(T, Self)> {
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
    fn file(target: &Path) -> io::Result<(File, Self)> {
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

/// A temporary file without a name, which vanishes with the process.
pub(crate) fn unnamed_file() -> io::Result<File> {
    let mut options = File::options();
    options.read(true).write(true).create_new(true).mode(0o600);
    let any = std::env::temp_dir().join("any");
    Beside::create(&any, |path| options.open(path)).map(|(file, _)| file)
}

/// Begins the recording of a run: a file with the bytes `begun` that is locked until it and its
/// duplicates are closed. Its cursor is at 0, for a writer that writes the same bytes first. At no
/// time is there a file under the name that is not a recording.
///
/// # Errors
/// [`Error::Write`]: it cannot be opened or written, or another run is recording to it.
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

fn refuse_recording_in_progress(path: &Path) -> io::Result<()> {
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

fn folder(path: &Path) -> PathBuf {
    let parent = path
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty());
    parent.map_or_else(|| PathBuf::from("."), Path::to_owned)
}

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

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.collect()
    }

    #[test]
    fn a_file_is_replaced_when_the_new_one_is_whole() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("answer.json");
        write_file(&path, b"one").unwrap();
        let mut second = OutputFile::create(&path).unwrap();
        second.write_all(b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        second.finish().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        assert_eq!(names(scratch.path()), ["answer.json"]);
    }

    #[test]
    fn a_file_that_is_not_finished_vanishes() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("answer.json");
        drop(OutputFile::create(&path).unwrap());
        assert_eq!(names(scratch.path()), [""; 0]);
        let kept = OutputFile::create(&path).unwrap();
        remove_unfinished();
        assert_eq!(names(scratch.path()), [""; 0]);
        drop(kept);
    }

    #[test]
    fn a_folder_gets_its_name_when_it_is_whole() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("deep/export");
        drop(OutputFolder::create(&path).unwrap());
        assert_eq!(names(&scratch.path().join("deep")), [""; 0]);
        std::fs::create_dir(&path).unwrap();
        let folder = OutputFolder::create(&path).unwrap();
        std::fs::write(folder.path().join("file"), "").unwrap();
        assert!(!path.join("file").exists());
        folder.finish().unwrap();
        assert_eq!(names(&path), ["file"]);
        assert!(matches!(OutputFolder::create(&path), Err(Error::Input(_))));
    }

    #[test]
    fn a_recording_in_progress_is_neither_recorded_to_nor_replaced() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("run.mcap");
        let run = lock_recording(&path, b"begin").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"begin");
        let duplicate = run.try_clone().unwrap();
        drop(run);
        let second = lock_recording(&path, b"other").unwrap_err();
        assert!(second.to_string().contains("another run"), "{second}");
        assert!(second.is_unusable_path());
        assert!(write_file(&path, b"import").is_err());
        drop(duplicate);
        let mut third = lock_recording(&path, b"third").unwrap();
        third.write_all(b"third run").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"third run");
    }
}
