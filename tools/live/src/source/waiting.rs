//! A file that is read on as it grows.

use std::fs::File;
use std::io::{self, Read};
use std::time::Duration;

use super::background::Outlet;

/// How often it is looked whether a file has grown.
const LOOKING: Duration = Duration::from_millis(50);
/// The footer of an MCAP file with its head, and the magic bytes after it.
const END_BYTES: usize = 37;
/// First bytes of the footer: its opcode and its length.
const FOOTER: [u8; 9] = [2, 20, 0, 0, 0, 0, 0, 0, 0];
/// First and last bytes of an MCAP file.
pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Why a file gives no more bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Over {
    /// It does, or nobody wants them.
    No,
    /// It is complete.
    Complete,
    /// Another file continues it.
    Continued,
    /// It became shorter than what was read.
    BegunAnew,
}

/// A file whose end is waited for.
pub(super) struct Waiting<'a> {
    file: File,
    outlet: &'a Outlet,
    /// Called while it waits: whether another file continues this one.
    idle: &'a mut dyn FnMut() -> bool,
    over: &'a mut Over,
    /// Number of bytes that were read, and the last of them.
    read: u64,
    last: Vec<u8>,
    is_continued: bool,
}

impl<'a> Waiting<'a> {
    /// Reads a file from its beginning. `over` says why it ended.
    pub(super) fn new(
        file: File,
        outlet: &'a Outlet,
        idle: &'a mut dyn FnMut() -> bool,
        over: &'a mut Over,
    ) -> Self {
        Self {
            file,
            outlet,
            idle,
            over,
            read: 0,
            last: Vec::new(),
            is_continued: false,
        }
    }

    fn took(&mut self, bytes: &[u8]) {
        self.read += bytes.len() as u64;
        let from = bytes.len().saturating_sub(END_BYTES);
        self.last
            .extend_from_slice(bytes.get(from..).unwrap_or_default());
        let surplus = self.last.len().saturating_sub(END_BYTES);
        self.last.drain(..surplus);
    }

    /// Whether the file ends here, and why.
    fn is_over(&mut self) -> io::Result<bool> {
        let is_complete = self.last.starts_with(&FOOTER) && self.last.ends_with(MAGIC);
        let over = match () {
            () if is_complete => Over::Complete,
            () if self.file.metadata()?.len() < self.read => Over::BegunAnew,
            // What was written before the next file began has been read by now.
            () if self.is_continued => Over::Continued,
            () => Over::No,
        };
        *self.over = over;
        Ok(over != Over::No)
    }
}

impl Read for Waiting<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if bytes.is_empty() {
            return Ok(0);
        }
        loop {
            let count = self.file.read(bytes)?;
            if count > 0 {
                self.took(bytes.get(..count).unwrap_or_default());
                return Ok(count);
            }
            if self.is_over()? || self.outlet.is_closed() {
                return Ok(0);
            }
            self.is_continued = (self.idle)();
            if !self.is_continued {
                self.outlet.wait(LOOKING);
            }
        }
    }
}
