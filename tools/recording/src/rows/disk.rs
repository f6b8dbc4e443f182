//! An unlinked temporary file that takes what would not fit into bounded memory.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::rc::Rc;

use slipstream_bag::output::unnamed_file;
use slipstream_bag::{Result, write_error};

/// A temporary file (in `TMPDIR`) shared by many lists that do not fit into memory. It is created with
/// the first block and has no name, so that it disappears with the process, however that ends.
///
/// An error is kept until [`Disk::check`] is called: whoever reads or writes rows does not handle it
/// row by row. After an error, nothing more is written, and reading ends early.
#[derive(Debug, Clone, Default)]
pub struct Disk {
    file: Rc<RefCell<Option<File>>>,
    error: Rc<RefCell<Option<io::Error>>>,
}

impl Disk {
    /// Another file that reports its errors to this one.
    pub fn sibling(&self) -> Self {
        Self {
            file: Rc::default(),
            error: Rc::clone(&self.error),
        }
    }

    /// Appends bytes and returns where they begin.
    pub fn append(&self, bytes: &[u8]) -> u64 {
        if self.error.borrow().is_some() {
            return 0;
        }
        self.try_append(bytes).unwrap_or_else(|error| {
            self.error.borrow_mut().get_or_insert(error);
            0
        })
    }

    /// Reads the bytes at an offset. Returns whether they could be read.
    pub fn read(&self, offset: u64, bytes: &mut [u8]) -> bool {
        if self.error.borrow().is_some() {
            return false;
        }
        match self.try_read(offset, bytes) {
            Ok(()) => true,
            Err(error) => {
                self.error.borrow_mut().get_or_insert(error);
                false
            }
        }
    }

    /// Whether everything so far was written and read.
    ///
    /// # Errors
    /// The first error of the operating system, mostly that the file system is full.
    pub fn check(&self) -> Result<()> {
        match self.error.borrow_mut().take() {
            Some(error) => Err(write_error(&std::env::temp_dir())(error)),
            None => Ok(()),
        }
    }

    fn try_append(&self, bytes: &[u8]) -> io::Result<u64> {
        let mut place = self.file.borrow_mut();
        let file = match &mut *place {
            Some(file) => file,
            None => place.insert(unnamed_file()?),
        };
        let offset = file.seek(SeekFrom::End(0))?;
        file.write_all(bytes)?;
        Ok(offset)
    }

    fn try_read(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        let mut place = self.file.borrow_mut();
        let file = place.as_mut().ok_or(io::ErrorKind::UnexpectedEof)?;
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(bytes)
    }
}
