//! The page on the heap, for loom, whose models are no memory that processes could share.

use std::io;
use std::path::Path;

use super::layout::{Header, Slot};

/// The page.
#[derive(Debug)]
pub(super) struct Mapping {
    header: Header,
    slots: Box<[Slot]>,
}

impl Mapping {
    /// A new page.
    #[expect(clippy::unnecessary_wraps, reason = "as the mapping of a file")]
    pub(super) fn create(_: &Path, robots: usize) -> io::Result<Self> {
        Ok(Self {
            header: Header::default(),
            slots: (0..robots).map(|_| Slot::default()).collect(),
        })
    }

    /// There is no file to open.
    pub(super) fn open(_: &Path) -> io::Result<Self> {
        Err(io::ErrorKind::Unsupported.into())
    }

    /// Number of robots, and so of slots.
    pub(super) fn robots(&self) -> usize {
        self.slots.len()
    }

    pub(super) fn header(&self) -> &Header {
        &self.header
    }

    pub(super) fn slot(&self, robot: usize) -> &Slot {
        &self.slots[robot]
    }
}
