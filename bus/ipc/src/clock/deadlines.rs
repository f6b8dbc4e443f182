//! Deadline counting of a periodic loop: ticks, missed deadlines, latest wake-up.

use serde::{Deserialize, Serialize};

/// Deadline counts of one loop. A tick is due at a whole multiple of the period, and its deadline
/// is the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Deadlines {
    /// Name of the loop in the trace.
    #[serde(skip)]
    name: &'static str,
    /// Ticks that were due.
    pub ticks: u64,
    /// Ticks that ended after the next one was due, and ticks that were skipped because of that.
    pub missed: u64,
    /// The latest wake-up after a tick was due (ns).
    pub latest_ns: i64,
}

impl Default for Deadlines {
    /// Counts of the only loop of the plant, `step`.
    fn default() -> Self {
        Self::of("step")
    }
}

impl Deadlines {
    /// Counts of the loop `name` before its first tick.
    pub fn of(name: &'static str) -> Self {
        Self {
            name,
            ticks: 0,
            missed: 0,
            latest_ns: 0,
        }
    }

    /// Counts a tick that was due at `due_ns`, began at `began_ns` and was done at `done_ns`.
    pub fn count(&mut self, due_ns: i64, began_ns: i64, done_ns: i64, period_ns: i64) {
        self.ticks += 1;
        self.latest_ns = self.latest_ns.max(began_ns - due_ns);
        let missed = done_ns > due_ns + period_ns;
        self.missed += u64::from(missed);
        let of = self.name;
        tracing::debug!(name: "deadline", t_ns = due_ns, of, began_ns, done_ns, missed);
    }

    /// The counts as words of shared memory; `due_ns` is the time up to which ticks are counted.
    pub fn to_shared(self, due_ns: i64) -> [i64; 4] {
        let count = |count: u64| i64::try_from(count).unwrap_or(i64::MAX);
        [
            count(self.ticks),
            count(self.missed),
            self.latest_ns,
            due_ns,
        ]
    }

    /// The counts of the loop `name` that a process left behind in shared memory. Ticks that were due
    /// after the counted ones and before `now_ns` count as missed.
    pub fn from_shared(
        name: &'static str,
        [ticks, missed, latest_ns, due_ns]: [i64; 4],
        now_ns: i64,
        period_ns: i64,
    ) -> Self {
        let count = |count: i64| u64::try_from(count).unwrap_or(0);
        let due_until = |at_ns: i64| at_ns.div_euclid(period_ns.max(1));
        let counted_ns = if ticks == 0 { -1 } else { due_ns };
        let silent = count(due_until(now_ns - 1) - due_until(counted_ns));
        Self {
            name,
            ticks: count(ticks) + silent,
            missed: count(missed) + silent,
            latest_ns,
        }
    }

    /// Counts skipped ticks.
    pub fn skip(&mut self, ticks: u64) {
        self.ticks += ticks;
        self.missed += ticks;
        if ticks > 0 {
            tracing::debug!(name: "left_out", of = self.name, ticks);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_silent_process_left_out_is_missed() {
        let mut deadlines = Deadlines::of("inner");
        deadlines.count(0, 1, 2, 20);
        deadlines.count(20, 21, 22, 20);
        let restored =
            |now_ns| Deadlines::from_shared("inner", deadlines.to_shared(20), now_ns, 20);
        assert_eq!(restored(39), deadlines);
        assert_eq!((restored(61).ticks, restored(61).missed), (4, 2));
        let never = Deadlines::from_shared("inner", [0; 4], 45, 20);
        assert_eq!((never.ticks, never.missed), (3, 3), "due at 0, 20 and 40");
    }

    #[test]
    fn a_deadline_is_missed_once_the_next_tick_is_due() {
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
}
