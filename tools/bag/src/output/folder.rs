//! Output folders.

use std::io;
use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

use super::beside::{Beside, folder};
use crate::error::{Result, write_error};

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
    /// [`Error::Write`](crate::Error::Write): the folder cannot be created; [`Error::Input`](crate::Error::Input): the existing one is not empty.
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
    /// [`Error::Write`](crate::Error::Write); the folder vanishes.
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

#[cfg(test)]
mod tests {
    use super::super::beside::names;
    use super::*;
    use crate::error::Error;

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
}
