//! Integer nanoseconds: the only measure of time in a run.
//!
//! A time `…_ns` counts from the run's beginning, a duration has no origin. Seconds as `f64` appear
//! where people write them (experiment files) and inside formulas, nowhere in between.

/// Nanoseconds in a second.
pub const NS_PER_S: i64 = 1_000_000_000;

/// Seconds to the nearest nanosecond; what lies beyond the range of `i64` (292 years) sticks to it.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a cast from f64 saturates; 292 years are enough"
)]
pub fn ns_from_s(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

/// Nanoseconds as seconds, exact up to 104 days.
#[expect(
    clippy::cast_precision_loss,
    reason = "the loss begins after 104 days, far beyond a run"
)]
pub fn s_from_ns(ns: i64) -> f64 {
    ns as f64 / 1e9
}

/// When the loops of a robot are due: at whole multiples of each period from time 0 on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Schedule {
    /// Period of the outer loop (ns), above 0.
    pub outer_ns: i64,
    /// Period of the inner loop (ns), above 0.
    pub inner_ns: i64,
}

/// Which loops are due at an instant. At coinciding ticks the outer loop runs before the inner.
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
    /// What is due exactly at `now_ns`.
    pub fn due(&self, now_ns: i64) -> Due {
        Due {
            outer: now_ns % self.outer_ns == 0,
            inner: now_ns % self.inner_ns == 0,
        }
    }

    /// The first instant after `now_ns` (0 or later) at which anything is due.
    pub fn next_after(&self, now_ns: i64) -> i64 {
        let next = |period: i64| (now_ns / period + 1) * period;
        next(self.outer_ns).min(next(self.inner_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twenty_and_fifty_hertz_meet_ten_times_a_second() {
        let schedule = Schedule {
            outer_ns: 50_000_000,
            inner_ns: 20_000_000,
        };
        let (mut now, mut rounds, mut both) = (0, 0, 0);
        while now < NS_PER_S {
            let due = schedule.due(now);
            assert!(due.any());
            rounds += 1;
            both += i32::from(due.outer && due.inner);
            now = schedule.next_after(now);
        }
        assert_eq!((rounds, both), (60, 10));
    }

    #[test]
    fn seconds_round_to_the_nearest_nanosecond() {
        assert_eq!(ns_from_s(0.1), 100_000_000);
        assert_eq!(ns_from_s(0.1 + 0.2), 300_000_000);
        assert_eq!(s_from_ns(ns_from_s(14.999)), 14.999);
    }
}
