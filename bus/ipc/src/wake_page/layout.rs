//! Memory layout of the wake-up page: a header and one slot per robot, all atomic integers.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::atomic::{AtomicI64, AtomicU32, AtomicU64, Ordering};

use memmap2::{MmapOptions, MmapRaw};
use rustix::fs::{FallocateFlags, fallocate};

/// Identifies the layout. It changes with the layout, so that builds with different layouts do not
/// share a page.
const MAGIC: u32 = 0x5350_0002;

/// Number of words of an agent's checkpoint.
pub const CHECKPOINT_WORDS: usize = 6;

/// Number of words of the deadline counts of one loop.
pub const DEADLINE_WORDS: usize = 4;

/// The word `epoch` when no further round comes.
pub(super) const NO_MORE_ROUNDS: u32 = u32::MAX;

/// A word on its own cache line, so that processes waiting for different words do not disturb each
/// other.
#[derive(Debug, Default)]
#[repr(C, align(64))]
pub(super) struct CacheLine<T>(pub(super) T);

/// The header. Every bit pattern is valid; all zeros is the initial state.
#[derive(Debug, Default)]
#[repr(C)]
pub(super) struct Header {
    magic: AtomicU32,
    robots: AtomicU32,
    pub(super) stop: AtomicU32,
    pub(super) recorder_gone: AtomicU32,
    /// Number of deaths of the plant, at most one.
    pub(super) plant_deaths: AtomicU32,
    pub(super) now_ns: AtomicI64,
    pub(super) start_ns: AtomicI64,
    pub(super) speed_bits: AtomicU64,
    pub(super) spacing_bits: AtomicU64,
    /// Signs of life and deadline counts of the plant.
    pub(super) plant: CacheLine<Signs<1>>,
    /// Signs of life of the recorder.
    pub(super) recorder: CacheLine<Signs<0>>,
    pub(super) stage: CacheLine<AtomicU32>,
    pub(super) ready: CacheLine<AtomicU32>,
    pub(super) epoch: CacheLine<AtomicU32>,
    pub(super) answers: CacheLine<AtomicU32>,
}

/// What a process shows of itself, for the launcher: that it lives, and how it kept the deadlines of
/// its loops.
#[derive(Debug)]
#[repr(C)]
pub(super) struct Signs<const LOOPS: usize> {
    /// Counts up while the process makes progress.
    pub(super) beats: AtomicU32,
    pub(super) deadlines: [[AtomicI64; DEADLINE_WORDS]; LOOPS],
}

impl<const LOOPS: usize> Default for Signs<LOOPS> {
    fn default() -> Self {
        Self {
            beats: AtomicU32::default(),
            deadlines: std::array::from_fn(|_| Default::default()),
        }
    }
}

/// The state of one agent. It survives the agent's death.
#[derive(Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Slot {
    /// The last round that the agent answered.
    pub(super) answered: AtomicU32,
    /// Version of the checkpoint: odd while a write is under way, 0 before the first.
    pub(super) version: AtomicU32,
    /// Number of deaths of the agent.
    pub(super) deaths: AtomicU32,
    /// Signs of life, and deadline counts of outer and inner loop.
    pub(super) signs: Signs<2>,
    pub(super) checkpoint: [AtomicU64; CHECKPOINT_WORDS],
}

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
