//! Memory layout of the wake-up page: a header and one slot per robot, all atomic integers.

use super::sync::{AtomicI64, AtomicU32, AtomicU64, Word};

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
    pub(super) magic: AtomicU32,
    pub(super) robots: AtomicU32,
    pub(super) stop: AtomicU32,
    pub(super) recorder_gone: AtomicU32,
    /// Counts up whenever the recorder finds that it has taken all chunks of records; wraps around.
    pub(super) emptied: AtomicU32,
    /// Number of robots whose agents run on another host.
    pub(super) remote: AtomicU32,
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
    pub(super) stage: CacheLine<Word>,
    pub(super) ready: CacheLine<Word>,
    pub(super) epoch: CacheLine<Word>,
    pub(super) answers: CacheLine<Word>,
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
    /// 1 if the agent runs on another host, and nobody stands for it on this one.
    pub(super) remote: AtomicU32,
    /// Number of deaths of the agent.
    pub(super) deaths: AtomicU32,
    /// Signs of life, and deadline counts of outer and inner loop.
    pub(super) signs: Signs<2>,
    pub(super) checkpoint: [AtomicU64; CHECKPOINT_WORDS],
}
