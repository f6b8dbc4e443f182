//! Ends processes that hang: those that show no sign of life, and those that do not end when they
//! should. The launcher never waits for ever.

use std::time::{Duration, Instant};

use slipstream_ipc::wake_page::Stage;

use super::launcher::Run;
use crate::role::Role;

/// Time to end after a stop.
const STOP_TIMEOUT: Duration = Duration::from_millis(800);
/// Time to end after the plant's last step, and for the recorder to write the rest after all others
/// have ended.
const END_TIMEOUT: Duration = Duration::from_secs(30);
/// What one more robot adds to these times on a machine with few cores: to start its process, to give it
/// its turn, and to end it.
const START_TIME: Duration = Duration::from_millis(50);
/// What an agent's own program adds to the time to start: an interpreter with its libraries.
const PROGRAM_START_TIME: Duration = Duration::from_secs(5);
const TURN_TIME: Duration = Duration::from_millis(20);
const STOP_TIME: Duration = Duration::from_millis(5);

impl Run<'_> {
    /// Kills the processes that hang. Their ends are handled like any other death.
    pub(super) fn kill_hanging(&mut self) {
        let now = Instant::now();
        let deadline = self.end_timeout();
        for index in 0..self.children.len() {
            let child = &self.children[index];
            if !child.is_running() || child.was_killed() {
                continue;
            }
            let limit = self.longest_silence(child.role);
            let beats = self.wake_page.beats(child.role.member());
            let child = &mut self.children[index];
            let silent = child.silence.look(beats, now);
            let sign = if silent > limit {
                Some(format!("no sign of life for {:.1} s", silent.as_secs_f64()))
            } else {
                let missed =
                    deadline.filter(|&(since, timeout)| now.duration_since(since) > timeout);
                missed.map(|(_, timeout)| {
                    format!("it did not end within {} s", timeout.as_secs_f64())
                })
            };
            if let Some(sign) = sign {
                child.kill(
                    "hangs",
                    format!(": {sign}, {}; it was killed", child.state()),
                );
            }
        }
    }

    /// From when on, and after how much time, every process should have ended. `None` while the run
    /// goes on.
    fn end_timeout(&self) -> Option<(Instant, Duration)> {
        let timeout = STOP_TIMEOUT + STOP_TIME * self.experiment.settings.robots.count;
        let stopped = self.stopped.map(|since| match self.drained {
            // The recorder gets twice the time.
            Some(_) => (since, 2 * timeout),
            None => (since, timeout),
        });
        let ended = self.drained.or(self.over);
        stopped.or(ended.map(|since| (since, END_TIMEOUT)))
    }

    /// How long a process may show no sign of life.
    fn longest_silence(&self, role: Role) -> Duration {
        let settings = &self.experiment.settings;
        let watchdog = Duration::from_secs_f64(settings.watchdog_s);
        match (self.wake_page.stage(), role) {
            (Stage::Starting | Stage::Services, _) => {
                let programs = u32::try_from(self.part.programs().len()).unwrap_or(u32::MAX);
                let libraries = PROGRAM_START_TIME.saturating_mul(programs);
                watchdog + START_TIME * settings.robots.count + libraries
            }
            // It writes what is left, without an end in between.
            (Stage::Drained, role) if role.ends_last() => watchdog.max(END_TIMEOUT),
            _ => watchdog + TURN_TIME * settings.robots.count,
        }
    }
}
