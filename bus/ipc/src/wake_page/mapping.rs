//! Mapping of the page: a file that every process of the run maps into its memory.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::atomic::Ordering;

use memmap2::{MmapOptions, MmapRaw};
use rustix::fs::{FallocateFlags, fallocate};

use super::layout::{Header, Slot};

/// Identifies the layout. It changes with the layout, so that builds with different layouts do not
/// share a page.
const MAGIC: u32 = 0x5350_0004;

/// The mapped page.
#[derive(Debug)]
pub(super) struct Mapping {
    map: MmapRaw,
    robots: usize,
}

impl Mapping {
    /// Creates the page as a new file.
    pub(super) fn create(path: &Path, robots: usize) -> io::Result<Self> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(path)?;
        // Reserves the memory now: a write to a page that the system cannot provide ends the process
        // with SIGBUS.
        fallocate(&file, FallocateFlags::empty(), 0, size(robots) as u64)?;
        let mapping = Self::map(&file, robots)?;
        let robots = u32::try_from(robots).map_err(io::Error::other)?;
        mapping.header().robots.store(robots, Ordering::Relaxed);
        mapping.header().magic.store(MAGIC, Ordering::Release);
        Ok(mapping)
    }

    /// Opens the page in an existing file.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        let header_only = Self::map(&file, 0)?;
        let header = header_only.header();
        if header.magic.load(Ordering::Acquire) != MAGIC {
            return Err(io::Error::other("is the wake-up page of another build"));
        }
        let robots = header.robots.load(Ordering::Relaxed) as usize;
        drop(header_only);
        Self::map(&file, robots)
    }

    fn map(file: &File, robots: usize) -> io::Result<Self> {
        let needed = size(robots);
        if file.metadata()?.len() < needed as u64 {
            return Err(io::Error::other("is too short for a wake-up page"));
        }
        let map = MmapOptions::new().len(needed).map_raw(file)?;
        Ok(Self { map, robots })
    }

    /// Number of robots, and so of slots.
    pub(super) fn robots(&self) -> usize {
        self.robots
    }

    pub(super) fn header(&self) -> &Header {
        // SAFETY: the mapping is page-aligned, at least `size_of::<Header>()` long (`map`) and
        // lives as long as `self`. `Header` consists of atomics: every bit pattern is valid, and
        // other processes may change them at any time. The mapping would become invalid only if a
        // process of the same user truncated the file, which none of this workspace does.
        #[expect(unsafe_code, reason = "a view of shared memory; argued above")]
        unsafe {
            &*self.map.as_ptr().cast::<Header>()
        }
    }

    pub(super) fn slot(&self, robot: usize) -> &Slot {
        assert!(robot < self.robots, "robot {robot} of {}", self.robots);
        // SAFETY: as for `header`. `map` mapped `robots` slots behind the header, `robot` is
        // checked, and the size of the header is a multiple of the alignment of a slot (64 bytes
        // both).
        #[expect(unsafe_code, reason = "a view of shared memory; argued above")]
        unsafe {
            &*self
                .map
                .as_ptr()
                .add(size_of::<Header>())
                .cast::<Slot>()
                .add(robot)
        }
    }
}

fn size(robots: usize) -> usize {
    size_of::<Header>() + robots * size_of::<Slot>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_not_a_wake_up_page_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wake_page");
        std::fs::write(&path, [0; 4096]).unwrap();
        assert!(Mapping::open(&path).is_err());
        std::fs::write(&path, []).unwrap();
        assert!(Mapping::open(&path).is_err());
    }
}
