//! Monotonic clock and the time of the run on it.
//!
//! The time of the system and the time of the run have different types, so that they cannot be
//! mixed up.

use rustix::thread::{ClockId, clock_nanosleep_absolute};
use rustix::time::{Timespec, clock_gettime};
use slipstream_bus::time::NS_PER_S;

/// A point in time on the system's monotonic clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Monotonic {
    ns: i64,
}

/// Maps the system's monotonic clock to the time of the run (ns since its start).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WallClock {
    start: Monotonic,
}

impl Monotonic {
    /// The current time.
    pub fn now() -> Self {
        let Timespec { tv_sec, tv_nsec } = clock_gettime(ClockId::Monotonic);
        Self {
            ns: tv_sec * NS_PER_S + tv_nsec,
        }
    }

    /// A point in time received from another process of this host (ns).
    pub fn from_shared(ns: i64) -> Self {
        Self { ns }
    }

    /// The point in time for another process of this host (ns).
    pub fn to_shared(self) -> i64 {
        self.ns
    }

    /// The point in time `ns` later (ns).
    #[must_use]
    pub fn plus_ns(self, ns: i64) -> Self {
        Self { ns: self.ns + ns }
    }
}

impl WallClock {
    /// The clock of a run that starts, or started, at `start`.
    pub fn new(start: Monotonic) -> Self {
        Self { start }
    }

    /// The current time of the run (ns), negative before its start.
    pub fn now_ns(&self) -> i64 {
        self.ns_at(Monotonic::now())
    }

    /// The time of the run at a point in time (ns), negative before its start.
    pub fn ns_at(&self, at: Monotonic) -> i64 {
        at.ns - self.start.ns
    }

    /// Sleeps until the time of the run is `deadline_ns`.
    pub fn sleep_until(&self, deadline_ns: i64) {
        let at_ns = self.start.ns + deadline_ns;
        let timespec = Timespec {
            tv_sec: at_ns.div_euclid(NS_PER_S),
            tv_nsec: at_ns.rem_euclid(NS_PER_S),
        };
        // A signal interrupts the sleep: continue. A valid time causes no other error.
        while clock_nanosleep_absolute(ClockId::Monotonic, &timespec)
            == Err(rustix::io::Errno::INTR)
        {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleeping_does_not_end_before_the_deadline() {
        let clock = WallClock::new(Monotonic::now());
        clock.sleep_until(2_000_000);
        assert!(clock.now_ns() >= 2_000_000);
    }
}
