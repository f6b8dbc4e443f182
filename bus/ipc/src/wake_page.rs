//! The wake_page page: a shared mapping through which the processes of a run wake each other.
//!
//! Data goes through pub-sub; this page holds only who waits for what. In lockstep the plant raises
//! the epoch, which wakes all agents with one call; each answers with that epoch, and only the last
//! one wakes the plant. Every wait ends by itself after a while, so that whoever waits can look
//! whether the others live.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::atomic::{AtomicI64, AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

use memmap2::{MmapOptions, MmapRaw};
use rustix::thread::futex::{self, Flags, Timespec};

/// Changes with the layout: processes of two builds do not meet on one page.
const MAGIC: u32 = 0x5350_0001;

/// How far a run has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Stage {
    /// Processes are being started.
    Starting = 0,
    /// The plant has created all services.
    Services = 1,
    /// Everybody is connected.
    Running = 2,
    /// The plant has made its last step.
    Over = 3,
    /// Nobody but the recorder is left: it may close the file.
    Drained = 4,
}

/// One word on a cache line of its own.
#[derive(Debug, Default)]
#[repr(C, align(64))]
struct Line<T>(T);

/// Everything is an atomic integer: all bit patterns are valid, zero is the beginning.
#[derive(Debug, Default)]
#[repr(C)]
struct Head {
    magic: AtomicU32,
    robots: AtomicU32,
    stop: AtomicU32,
    recorder_gone: AtomicU32,
    /// How often the plant has died; once at most.
    plant_deaths: AtomicU32,
    now_ns: AtomicI64,
    start_ns: AtomicI64,
    speed_bits: AtomicU64,
    spacing_bits: AtomicU64,
    stage: Line<AtomicU32>,
    ready: Line<AtomicU32>,
    epoch: Line<AtomicU32>,
    done: Line<AtomicU32>,
}

/// What one agent says. It survives the agent's death.
#[derive(Debug, Default)]
#[repr(C, align(64))]
struct Slot {
    /// The last epoch that it answered.
    answered: AtomicU32,
    /// Counts the writes of the checkpoint below; odd while one is under way.
    version: AtomicU32,
    /// How often the agent has died.
    deaths: AtomicU32,
    checkpoint: [AtomicU64; CHECKPOINT_WORDS],
}

/// Words that an agent can leave for its successor.
pub const CHECKPOINT_WORDS: usize = 6;

/// The page of a run, mapped.
#[derive(Debug)]
pub struct WakePage {
    map: MmapRaw,
    robots: usize,
}

impl WakePage {
    /// Creates the page of a run of `robots` robots as a new file.
    ///
    /// # Errors
    /// When the file cannot be created or mapped.
    pub fn create(path: &Path, robots: usize) -> io::Result<Self> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(path)?;
        file.set_len(size(robots) as u64)?;
        let wake_page = Self::map(&file, robots)?;
        let robots = u32::try_from(robots).map_err(io::Error::other)?;
        wake_page.head().robots.store(robots, Ordering::Relaxed);
        wake_page.head().magic.store(MAGIC, Ordering::Release);
        Ok(wake_page)
    }

    /// Opens the page of a run.
    ///
    /// # Errors
    /// When the file is no page of this build.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        let wake_page = Self::map(&file, 0)?;
        let head = wake_page.head();
        if head.magic.load(Ordering::Acquire) != MAGIC {
            return Err(io::Error::other("is the wake_page page of another build"));
        }
        let robots = head.robots.load(Ordering::Relaxed) as usize;
        drop(wake_page);
        Self::map(&file, robots)
    }

    fn map(file: &File, robots: usize) -> io::Result<Self> {
        let needed = size(robots);
        if file.metadata()?.len() < needed as u64 {
            return Err(io::Error::other("is too short for a wake_page page"));
        }
        let map = MmapOptions::new().len(needed).map_raw(file)?;
        Ok(Self { map, robots })
    }

    fn head(&self) -> &Head {
        // SAFETY: the mapping is page-aligned, at least `size_of::<Head>()` long (`map`), lives as
        // long as `self`, and `Head` consists of atomics, for which every bit pattern is valid and
        // changes by other processes are what they are made for. The file only shrinks if somebody
        // of the same user truncates it; this house never does.
        #[expect(unsafe_code, reason = "a view of shared memory; argued above")]
        unsafe {
            &*self.map.as_ptr().cast::<Head>()
        }
    }

    fn slot(&self, robot: usize) -> &Slot {
        assert!(robot < self.robots, "robot {robot} of {}", self.robots);
        // SAFETY: as for `head`; `size` left room for `robots` slots behind the head, whose length
        // is a multiple of the slots' alignment (both are of 64-byte lines), and `robot` is checked.
        #[expect(unsafe_code, reason = "a view of shared memory; argued above")]
        unsafe {
            &*self
                .map
                .as_ptr()
                .add(size_of::<Head>())
                .cast::<Slot>()
                .add(robot)
        }
    }

    /// How far the run has come.
    pub fn stage(&self) -> Stage {
        match self.head().stage.0.load(Ordering::Acquire) {
            0 => Stage::Starting,
            1 => Stage::Services,
            2 => Stage::Running,
            3 => Stage::Over,
            _ => Stage::Drained,
        }
    }

    /// Lets everybody go on to a later stage. Who is further stays there.
    pub fn advance(&self, stage: Stage) {
        self.head()
            .stage
            .0
            .fetch_max(stage as u32, Ordering::AcqRel);
        wake_all(&self.head().stage.0);
        if stage >= Stage::Over {
            // Agents that sleep on the epoch look at the stage when they wake.
            wake_all(&self.head().epoch.0);
        }
    }

    /// Waits until the run has reached `stage`, or `timeout` is over. Says whether it has.
    pub fn wait_stage(&self, stage: Stage, timeout: Duration) -> bool {
        let word = &self.head().stage.0;
        let now = word.load(Ordering::Acquire);
        if now < stage as u32 {
            wait(word, now, timeout);
        }
        word.load(Ordering::Acquire) >= stage as u32
    }

    /// One process more is connected.
    pub fn signal_ready(&self) {
        self.head().ready.0.fetch_add(1, Ordering::AcqRel);
        wake_all(&self.head().ready.0);
    }

    /// Waits until `processes` are connected, or `timeout` is over. Says whether they are.
    pub fn wait_ready(&self, processes: u32, timeout: Duration) -> bool {
        let word = &self.head().ready.0;
        let now = word.load(Ordering::Acquire);
        if now < processes {
            wait(word, now, timeout);
        }
        word.load(Ordering::Acquire) >= processes
    }

    /// Asks the run to stop.
    pub fn stop(&self) {
        self.head().stop.store(1, Ordering::Release);
        wake_all(&self.head().done.0);
    }

    /// Whether somebody asked the run to stop.
    pub fn stopping(&self) -> bool {
        self.head().stop.load(Ordering::Acquire) != 0
    }

    /// Says that nobody takes records any more.
    pub fn set_recorder_gone(&self) {
        self.head().recorder_gone.store(1, Ordering::Release);
    }

    /// Whether nobody takes records any more.
    pub fn recorder_gone(&self) -> bool {
        self.head().recorder_gone.load(Ordering::Acquire) != 0
    }

    /// Launcher: a robot's agent has died, or the plant.
    pub fn count_death(&self, robot: Option<usize>) {
        self.deaths_of(robot).fetch_add(1, Ordering::AcqRel);
    }

    /// How often a robot's agent has died, or the plant.
    pub fn deaths(&self, robot: Option<usize>) -> u32 {
        self.deaths_of(robot).load(Ordering::Acquire)
    }

    fn deaths_of(&self, robot: Option<usize>) -> &AtomicU32 {
        match robot {
            Some(robot) => &self.slot(robot).deaths,
            None => &self.head().plant_deaths,
        }
    }

    /// Plant: begins round `epoch`, never 0, and wakes all agents.
    pub fn begin_round(&self, epoch: u32) {
        self.head().done.0.store(0, Ordering::Release);
        self.head().epoch.0.store(epoch, Ordering::Release);
        wake_all(&self.head().epoch.0);
    }

    /// Plant: waits for all answers, or until `timeout` is over. Says whether all have come.
    pub fn wait_answers(&self, timeout: Duration) -> bool {
        let all = u32::try_from(self.robots).unwrap_or(u32::MAX);
        let word = &self.head().done.0;
        let now = word.load(Ordering::Acquire);
        if now < all {
            wait(word, now, timeout);
        }
        word.load(Ordering::Acquire) >= all
    }

    /// Plant: the first robot that has not answered round `epoch`.
    pub fn first_unanswered(&self, epoch: u32) -> Option<usize> {
        (0..self.robots).find(|&i| self.slot(i).answered.load(Ordering::Acquire) != epoch)
    }

    /// Agent: waits for a round other than `last`, or until `timeout` is over or the run is over.
    pub fn wait_round(&self, last: u32, timeout: Duration) -> Option<u32> {
        let word = &self.head().epoch.0;
        if word.load(Ordering::Acquire) == last && self.stage() < Stage::Over {
            wait(word, last, timeout);
        }
        Some(word.load(Ordering::Acquire)).filter(|&epoch| epoch != last)
    }

    /// Agent: answers round `epoch`. The last one wakes the plant.
    pub fn answer(&self, robot: usize, epoch: u32) {
        self.slot(robot).answered.store(epoch, Ordering::Release);
        let before = self.head().done.0.fetch_add(1, Ordering::AcqRel);
        if before as usize + 1 == self.robots {
            wake_all(&self.head().done.0);
        }
    }

    /// Plant: how far it has come: the time, the front robot's speed (m/s), the largest spacing
    /// error so far (m).
    pub fn publish_progress(&self, now_ns: i64, speed_m_s: f64, spacing_error_m: f64) {
        self.head().now_ns.store(now_ns, Ordering::Relaxed);
        self.head()
            .speed_bits
            .store(speed_m_s.to_bits(), Ordering::Relaxed);
        self.head()
            .spacing_bits
            .store(spacing_error_m.to_bits(), Ordering::Relaxed);
    }

    /// What the plant told last.
    pub fn progress(&self) -> (i64, f64, f64) {
        let head = self.head();
        let float = |word: &AtomicU64| f64::from_bits(word.load(Ordering::Relaxed));
        let now_ns = head.now_ns.load(Ordering::Relaxed);
        (now_ns, float(&head.speed_bits), float(&head.spacing_bits))
    }

    /// Wall clock: when time 0 was, by the system's monotonic clock (ns).
    pub fn set_start_ns(&self, start_ns: i64) {
        self.head().start_ns.store(start_ns, Ordering::Release);
    }

    /// Wall clock: when time 0 was, by the system's monotonic clock (ns).
    pub fn start_ns(&self) -> i64 {
        self.head().start_ns.load(Ordering::Acquire)
    }

    /// Agent: leaves checkpoint for its successor.
    pub fn store_checkpoint(&self, robot: usize, checkpoint: [u64; CHECKPOINT_WORDS]) {
        let slot = self.slot(robot);
        let version = slot.version.load(Ordering::Relaxed) | 1;
        slot.version.store(version, Ordering::SeqCst);
        for (word, note) in slot.checkpoint.iter().zip(checkpoint) {
            word.store(note, Ordering::SeqCst);
        }
        slot.version
            .store(version.wrapping_add(1), Ordering::SeqCst);
    }

    /// Agent: what a predecessor left; `None` when there was none or it died while writing.
    pub fn checkpoint(&self, robot: usize) -> Option<[u64; CHECKPOINT_WORDS]> {
        let slot = self.slot(robot);
        let version = slot.version.load(Ordering::SeqCst);
        let whole = version != 0 && version.is_multiple_of(2);
        whole.then(|| [0, 1, 2, 3, 4, 5].map(|i: usize| slot.checkpoint[i].load(Ordering::SeqCst)))
    }
}

fn size(robots: usize) -> usize {
    size_of::<Head>() + robots * size_of::<Slot>()
}

/// Sleeps while the word has this value, at most for `timeout`. May return early.
fn wait(word: &AtomicU32, value: u32, timeout: Duration) {
    let timeout = Timespec {
        tv_sec: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: i64::from(timeout.subsec_nanos()),
    };
    // Shared between processes, hence no PRIVATE flag. Whatever ends the wait, callers look again.
    let _ = futex::wait(word, Flags::empty(), value, Some(&timeout));
}

fn wake_all(word: &AtomicU32) {
    // Waking cannot fail on a mapped and aligned word.
    let _ = futex::wake(word, Flags::empty(), i32::MAX as u32);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_go_back_and_forth_between_two_mappings() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wake_page");
        let plant = WakePage::create(&path, 2).unwrap();
        let timeout = Duration::from_secs(10);
        std::thread::scope(|scope| {
            for robot in 0..2 {
                let agent = WakePage::open(&path).unwrap();
                scope.spawn(move || {
                    let mut last = 0;
                    while agent.stage() < Stage::Over {
                        if let Some(epoch) = agent.wait_round(last, timeout) {
                            last = epoch;
                            agent.answer(robot, epoch);
                        }
                    }
                });
            }
            for epoch in 1..1000 {
                plant.begin_round(epoch);
                while !plant.wait_answers(timeout) {}
                assert_eq!(plant.first_unanswered(epoch), None);
            }
            plant.advance(Stage::Over);
        });
    }

    #[test]
    fn who_does_not_answer_is_named_and_nobody_waits_for_ever() {
        let folder = tempfile::tempdir().unwrap();
        let wake_page = WakePage::create(&folder.path().join("wake_page"), 3).unwrap();
        wake_page.begin_round(7);
        wake_page.answer(0, 7);
        wake_page.answer(2, 7);
        assert!(!wake_page.wait_answers(Duration::from_millis(5)));
        assert_eq!(wake_page.first_unanswered(7), Some(1));
    }

    #[test]
    fn notes_half_written_are_none() {
        let folder = tempfile::tempdir().unwrap();
        let wake_page = WakePage::create(&folder.path().join("wake_page"), 1).unwrap();
        assert_eq!(wake_page.checkpoint(0), None);
        wake_page.store_checkpoint(0, [1, 2, 3, 4, 5, 6]);
        assert_eq!(wake_page.checkpoint(0), Some([1, 2, 3, 4, 5, 6]));
        wake_page.slot(0).version.fetch_add(1, Ordering::SeqCst);
        assert_eq!(wake_page.checkpoint(0), None);
    }

    #[test]
    fn a_file_that_is_no_page_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wake_page");
        std::fs::write(&path, [0; 4096]).unwrap();
        assert!(WakePage::open(&path).is_err());
        std::fs::write(&path, []).unwrap();
        assert!(WakePage::open(&path).is_err());
    }
}
