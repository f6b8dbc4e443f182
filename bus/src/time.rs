//! Time base: integer nanoseconds, and the periodic schedule of the control loops.
//!
//! A time named `…_ns` counts from the start of the run; a duration has no origin. Seconds as `f64`
//! appear only in experiment files and inside formulas.

/// Nanoseconds in a second.
pub const NS_PER_S: i64 = 1_000_000_000;

/// Converts seconds to the nearest nanosecond. Saturates at the range of `i64` (292 years).
#[expect(
    clippy::cast_possible_truncation,
    reason = "a cast from f64 saturates; 292 years are enough"
)]
pub fn ns_from_s(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

/// Converts nanoseconds to seconds. Exact up to 104 days.
#[expect(
    clippy::cast_precision_loss,
    reason = "the loss begins after 104 days, far beyond a run"
)]
pub fn s_from_ns(ns: i64) -> f64 {
    ns as f64 / 1e9
}

/// Periods of a robot's control loops. A loop is due at whole multiples of its period from time 0
/// on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Schedule {
    /// Period of the outer loop (ns), above 0.
    pub outer_ns: i64,
    /// Period of the inner loop (ns), above 0.
    pub inner_ns: i64,
}

/// Which loops are due at an instant. If both are due, the outer loop runs first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Due {
    /// The outer loop is due.
    pub outer: bool,
    /// The inner loop is due.
    pub inner: bool,
}

impl Due {
    /// Whether any loop is due.
    pub fn any(self) -> bool {
        self.outer || self.inner
    }
}

impl Schedule {
    /// The loops due exactly at `now_ns`.
    pub fn due(&self, now_ns: i64) -> Due {
        Due {
            outer: now_ns % self.outer_ns == 0,
            inner: now_ns % self.inner_ns == 0,
        }
    }

    /// The first instant after `now_ns` (0 or later) at which a loop is due.
    pub fn next_after(&self, now_ns: i64) -> i64 {
        let next = |period: i64| (now_ns / period + 1) * period;
        next(self.outer_ns).min(next(self.inner_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_of_20_and_50_hz_coincide_ten_times_a_second() {
        let schedule = Schedule {
            outer_ns: 50_000_000,
            inner_ns: 20_000_000,
        };
        let (mut now, mut instants, mut both) = (0, 0, 0);
        while now < NS_PER_S {
            let due = schedule.due(now);
            assert!(due.any());
            instants += 1;
            both += i32::from(due.outer && due.inner);
            now = schedule.next_after(now);
        }
        assert_eq!((instants, both), (60, 10));
    }

    #[test]
    fn seconds_round_to_the_nearest_nanosecond() {
        assert_eq!(ns_from_s(0.1), 100_000_000);
        assert_eq!(ns_from_s(0.1 + 0.2), 300_000_000);
        assert_eq!(s_from_ns(ns_from_s(14.999)), 14.999);
    }
}
