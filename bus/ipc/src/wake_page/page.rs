//! The wake-up page of a run: stage, readiness, stop request, deaths and progress.

use std::io;
use std::path::Path;
use std::time::Duration;

use slipstream_bus::message::RobotIndex;

#[cfg(feature = "loom")]
use super::heap::Mapping;
use super::layout::{Header, NO_MORE_ROUNDS};
#[cfg(not(feature = "loom"))]
use super::mapping::Mapping;

use super::stage::Stage;
use super::sync::{AtomicU32, AtomicU64, Ordering, Word, wait, wake_all};

/// The wake-up page of a run, mapped into this process.
///
/// Every process of the run maps the same page. The methods for the barrier of the lockstep are
/// called by plant and agents, the others as their descriptions say.
#[derive(Debug)]
pub struct WakePage {
    pub(super) mapping: Mapping,
}

impl WakePage {
    /// Creates the page of a run of `robots` robots as a new file.
    ///
    /// # Errors
    /// The file cannot be created or mapped.
    pub fn create(path: &Path, robots: usize) -> io::Result<Self> {
        let mapping = Mapping::create(path, robots)?;
        Ok(Self { mapping })
    }

    /// Opens the page of an existing run.
    ///
    /// # Errors
    /// The file cannot be opened, or was not written by this build.
    pub fn open(path: &Path) -> io::Result<Self> {
        let mapping = Mapping::open(path)?;
        Ok(Self { mapping })
    }

    /// Launcher, before it starts the processes: the agents of all robots but these run on other hosts.
    /// They take no part in the rounds of this host.
    pub fn set_local(&self, local: &[RobotIndex]) {
        let mut remote = 0;
        for robot in 0..self.mapping.robots() {
            let is_remote = !local.iter().any(|&own| own as usize == robot);
            let slot = self.mapping.slot(robot);
            slot.remote.store(u32::from(is_remote), Ordering::Release);
            remote += u32::from(is_remote);
        }
        self.header().remote.store(remote, Ordering::Release);
    }

    /// Whether the agent of a robot takes part in the rounds of this host.
    pub fn is_local(&self, robot: RobotIndex) -> bool {
        let slot = self.mapping.slot(robot as usize);
        slot.remote.load(Ordering::Acquire) == 0
    }

    /// Number of agents that take part in the rounds of this host.
    pub(super) fn local_agents(&self) -> u32 {
        let robots = u32::try_from(self.mapping.robots()).unwrap_or(u32::MAX);
        robots.saturating_sub(self.header().remote.load(Ordering::Acquire))
    }

    pub(super) fn header(&self) -> &Header {
        self.mapping.header()
    }

    /// The stage that the run has reached.
    pub fn stage(&self) -> Stage {
        Stage::from_number(self.header().stage.0.load(Ordering::Acquire))
    }

    /// Advances the run to `stage` and wakes all processes that wait for it. Has no effect if the
    /// run has already reached it.
    pub fn advance(&self, stage: Stage) {
        let header = self.header();
        header.stage.0.fetch_max(stage as u32, Ordering::AcqRel);
        wake_all(&header.stage.0);
        if stage >= Stage::Over {
            // An agent may have checked the stage and not be asleep yet: a changed word keeps it
            // from falling asleep.
            header.epoch.0.store(NO_MORE_ROUNDS, Ordering::Release);
            wake_all(&header.epoch.0);
        }
    }

    /// Waits until the run has reached `stage`, at most for `timeout`. Returns whether it has.
    pub fn wait_stage(&self, stage: Stage, timeout: Duration) -> bool {
        wait_at_least(&self.header().stage.0, stage as u32, timeout)
    }

    /// Signals that one more process is connected.
    pub fn signal_ready(&self) {
        let ready = &self.header().ready.0;
        ready.fetch_add(1, Ordering::AcqRel);
        wake_all(ready);
    }

    /// Waits until `processes` are connected, at most for `timeout`. Returns whether they are.
    pub fn wait_ready(&self, processes: u32, timeout: Duration) -> bool {
        wait_at_least(&self.header().ready.0, processes, timeout)
    }

    /// Asks all processes to stop, and wakes the plant if it waits for answers.
    pub fn stop(&self) {
        self.header().stop.store(1, Ordering::Release);
        wake_all(&self.header().answers.0);
    }

    /// Whether the run was asked to stop.
    pub fn stopping(&self) -> bool {
        self.header().stop.load(Ordering::Acquire) != 0
    }

    /// Launcher: signals that the recorder is gone.
    pub fn set_recorder_gone(&self) {
        self.header().recorder_gone.store(1, Ordering::Release);
    }

    /// Whether the recorder is gone, so that nobody receives records.
    pub fn recorder_gone(&self) -> bool {
        self.header().recorder_gone.load(Ordering::Acquire) != 0
    }

    /// Recorder: counts that it has looked at all senders and found nothing more.
    pub(crate) fn count_emptied(&self) {
        self.header().emptied.fetch_add(1, Ordering::AcqRel);
    }

    /// How often the recorder has found that it has taken everything; wraps around.
    pub(crate) fn emptied(&self) -> u32 {
        self.header().emptied.load(Ordering::Acquire)
    }

    /// Launcher: counts a death of a robot's agent, or of the plant (`None`).
    pub fn count_death(&self, robot: Option<usize>) {
        self.deaths_of(robot).fetch_add(1, Ordering::AcqRel);
    }

    /// Number of deaths of a robot's agent, or of the plant (`None`).
    pub fn deaths(&self, robot: Option<usize>) -> u32 {
        self.deaths_of(robot).load(Ordering::Acquire)
    }

    fn deaths_of(&self, robot: Option<usize>) -> &AtomicU32 {
        match robot {
            Some(robot) => &self.mapping.slot(robot).deaths,
            None => &self.header().plant_deaths,
        }
    }

    /// Plant: publishes the progress: time (ns), speed of the front robot (m/s), largest spacing
    /// error so far (m).
    pub fn publish_progress(&self, now_ns: i64, speed_m_s: f64, spacing_error_m: f64) {
        let header = self.header();
        let store = |word: &AtomicU64, value: f64| word.store(value.to_bits(), Ordering::Relaxed);
        header.now_ns.store(now_ns, Ordering::Relaxed);
        store(&header.speed_bits, speed_m_s);
        store(&header.spacing_bits, spacing_error_m);
    }

    /// The last published progress: time (ns), speed of the front robot (m/s), largest spacing
    /// error so far (m).
    pub fn progress(&self) -> (i64, f64, f64) {
        let header = self.header();
        let load = |word: &AtomicU64| f64::from_bits(word.load(Ordering::Relaxed));
        let now_ns = header.now_ns.load(Ordering::Relaxed);
        (now_ns, load(&header.speed_bits), load(&header.spacing_bits))
    }

    /// Plant, on the wall clock: sets time 0 of the run on the system's monotonic clock (ns).
    pub fn set_start_ns(&self, start_ns: i64) {
        self.header().start_ns.store(start_ns, Ordering::Release);
    }

    /// On the wall clock: time 0 of the run on the system's monotonic clock (ns).
    pub fn start_ns(&self) -> i64 {
        self.header().start_ns.load(Ordering::Acquire)
    }
}

/// Waits until the word is at least `target`, at most for `timeout`. Returns whether it is.
pub(super) fn wait_at_least(word: &Word, target: u32, timeout: Duration) -> bool {
    let value = word.load(Ordering::Acquire);
    if value < target {
        wait(word, value, timeout);
    }
    word.load(Ordering::Acquire) >= target
}
