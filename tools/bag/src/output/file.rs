//! Output files.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::beside::Beside;
use super::lock::refuse_recording_in_progress;
use crate::error::{Result, write_error};

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
/// [`Error::Write`](crate::Error::Write).
pub fn write_file(path: &Path, content: &[u8]) -> Result<()> {
    let mut file = OutputFile::create(path)?;
    file.write_all(content).map_err(write_error(path))?;
    file.finish()
}

impl OutputFile {
    /// Begins a file that will be called `path`.
    ///
    /// # Errors
    /// [`Error::Write`](crate::Error::Write): the file cannot be created, or a run is recording to it.
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
    /// [`Error::Write`](crate::Error::Write); the file vanishes.
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

#[cfg(test)]
mod tests {
    use super::super::beside::names;
    use super::super::lock::lock_recording;
    use super::*;

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
