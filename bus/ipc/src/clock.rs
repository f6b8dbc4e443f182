//! The wall clock of a run: absolute deadlines on the system's monotonic clock.
//!
//! The system's time and the run's time are two types, so that one cannot stand for the other.

use rustix::thread::{ClockId, clock_nanosleep_absolute};
use rustix::time::{Timespec, clock_gettime};
use serde::{Deserialize, Serialize};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

use slipstream_bus::time::NS_PER_S;

/// A point on the system's monotonic clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Monotonic {
    ns: i64,
}

/// Maps the system's time to the run's: nanoseconds since the run began.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WallClock {
    start: Monotonic,
}

impl Monotonic {
    /// Now.
    pub fn now() -> Self {
        let Timespec { tv_sec, tv_nsec } = clock_gettime(ClockId::Monotonic);
        Self {
            ns: tv_sec * NS_PER_S + tv_nsec,
        }
    }

    /// A point that another process told (ns).
    pub fn from_shared(ns: i64) -> Self {
        Self { ns }
    }

    /// For another process (ns).
    pub fn to_shared(self) -> i64 {
        self.ns
    }

    /// The point so much later (ns).
    #[must_use]
    pub fn plus_ns(self, ns: i64) -> Self {
        Self { ns: self.ns + ns }
    }
}

impl WallClock {
    /// A run that begins, or began, at `start`.
    pub fn new(start: Monotonic) -> Self {
        Self { start }
    }

    /// The run's time now (ns).
    pub fn now_ns(&self) -> i64 {
        Monotonic::now().ns - self.start.ns
    }

    /// Sleeps until the run's time is `deadline_ns`.
    pub fn sleep_until(&self, deadline_ns: i64) {
        let at = self.start.ns + deadline_ns;
        let timespec = Timespec {
            tv_sec: at.div_euclid(NS_PER_S),
            tv_nsec: at.rem_euclid(NS_PER_S),
        };
        // Interrupted by a signal: sleep on. Other errors cannot happen to a valid time.
        while clock_nanosleep_absolute(ClockId::Monotonic, &timespec)
            == Err(rustix::io::Errno::INTR)
        {}
    }
}

/// The deadlines of one loop: due at whole multiples of its period.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Deadlines {
    /// The loop's name in the trace.
    #[serde(skip)]
    name: &'static str,
    /// Ticks that were due.
    pub ticks: u64,
    /// Ticks whose work was not done before the next one was due, or that were left out because of
    /// that.
    pub missed: u64,
    /// The latest wake-up (ns).
    pub latest_ns: i64,
}

impl Default for Deadlines {
    /// Of the loop of a process that has but one, the plant.
    fn default() -> Self {
        Self::of("step")
    }
}

impl Deadlines {
    /// Of the loop `name`, before its first tick.
    pub fn of(name: &'static str) -> Self {
        Self {
            name,
            ticks: 0,
            missed: 0,
            latest_ns: 0,
        }
    }

    /// A tick that was due at `due_ns` began at `began_ns` and was done at `done_ns`.
    pub fn count(&mut self, due_ns: i64, began_ns: i64, done_ns: i64, period_ns: i64) {
        self.ticks += 1;
        self.latest_ns = self.latest_ns.max(began_ns - due_ns);
        let missed = done_ns > due_ns + period_ns;
        self.missed += u64::from(missed);
        let of = self.name;
        tracing::debug!(name: "deadline", t_ns = due_ns, of, began_ns, done_ns, missed);
    }

    /// Ticks that were left out.
    pub fn skip(&mut self, ticks: u64) {
        self.ticks += ticks;
        self.missed += ticks;
        if ticks > 0 {
            tracing::debug!(name: "left_out", of = self.name, ticks);
        }
    }
}

/// What the system permitted for the sake of punctuality.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct RealTime {
    /// SCHED_FIFO: other work does not delay the loops.
    pub fifo: bool,
    /// The memory is locked: no page has to be fetched.
    pub locked: bool,
}

impl RealTime {
    /// What both were permitted.
    #[must_use]
    pub fn both(self, other: Self) -> Self {
        Self {
            fifo: self.fifo && other.fifo,
            locked: self.locked && other.locked,
        }
    }

    /// Asks for all that helps this thread to be punctual.
    pub fn request(priority: u8) -> Self {
        let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1));
        let fifo = ThreadPriority::Crossplatform(match priority.try_into() {
            Ok(priority) => priority,
            Err(_) => return Self::default(),
        });
        let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        Self {
            fifo: set_thread_priority_and_policy(thread_native_id(), fifo, policy).is_ok(),
            locked: rustix::mm::mlockall(rustix::mm::MlockAllFlags::CURRENT).is_ok(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deadline_is_met_until_the_next_one_is_due() {
        let mut deadlines = Deadlines::default();
        deadlines.count(100, 101, 109, 10);
        deadlines.count(110, 115, 121, 10);
        deadlines.skip(2);
        assert_eq!(
            deadlines,
            Deadlines {
                ticks: 4,
                missed: 3,
                latest_ns: 5,
                ..Deadlines::default()
            }
        );
    }

    #[test]
    fn sleeping_ends_after_its_deadline() {
        let clock = WallClock::new(Monotonic::now());
        clock.sleep_until(2_000_000);
        assert!(clock.now_ns() >= 2_000_000);
    }
}
