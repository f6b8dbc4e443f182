//! The clock of a robot against the clock of the run, from what comes over the network alone.
//!
//! A message arrives later than it was stamped, by a delay that nobody knows but that is never negative. The fastest
//! message so far therefore bounds the offset between the clocks. The bound ages: two quartz clocks drift apart.

/// Largest drift of two clocks against each other (10⁻⁶).
const DRIFT_PPM: i64 = 100;
/// A stamp that is off by more than this (ns) shows that a clock was set, or that it is no time at all.
const JUMP_NS: i64 = 1_000_000_000;

/// Maps the stamps of one stream to the clock of the run.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StampClock {
    /// Arrival less stamp of the fastest message, and when that is from (ns); `None` before the first message.
    fastest: Option<(i64, i64)>,
    /// Largest delay beyond that of the fastest message (ns).
    pub(super) latest_ns: i64,
}

impl StampClock {
    /// When a message was stamped, on the clock of the run (ns): never after its arrival. A stamp of 0 is none.
    pub(super) fn on_run(&mut self, stamp_ns: i64, arrived_ns: i64) -> i64 {
        if stamp_ns == 0 {
            return arrived_ns;
        }
        let offset_ns = arrived_ns.saturating_sub(stamp_ns);
        let bound = self.fastest.map(|(fastest_ns, at_ns)| {
            let age_ns = arrived_ns.saturating_sub(at_ns).max(0);
            fastest_ns + age_ns / 1_000_000 * DRIFT_PPM
        });
        let fastest_ns = match bound {
            Some(bound_ns) if offset_ns.abs_diff(bound_ns) < JUMP_NS.unsigned_abs() => {
                bound_ns.min(offset_ns)
            }
            _ => offset_ns,
        };
        self.fastest = Some((fastest_ns, arrived_ns));
        self.latest_ns = self.latest_ns.max(offset_ns - fastest_ns);
        stamp_ns + fastest_ns
    }
}

impl StampClock {
    /// From now on time 0 of the run is what was `later_ns` before.
    pub(super) fn begin(&mut self, later_ns: i64) {
        let shifted = |(fastest_ns, at_ns): (i64, i64)| (fastest_ns - later_ns, at_ns - later_ns);
        self.fastest = self.fastest.map(shifted);
        self.latest_ns = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    #[test]
    fn the_fastest_message_sets_the_clock() {
        let mut clock = StampClock::default();
        let boot = 1_700_000_000_000 * MS;
        // Stamped at 0, 20, 40 … ms; delays of 9, 3, 12, 3 ms.
        let mapped: Vec<i64> = [(0, 9), (20, 3), (40, 12), (60, 3)]
            .map(|(t, delay)| clock.on_run(boot + t * MS, (t + delay) * MS))
            .to_vec();
        assert_eq!(&mapped[..2], [9 * MS, 23 * MS]);
        let error = |t_ns: i64, ms: i64| (t_ns - ms * MS).abs();
        assert!(
            error(mapped[2], 43) < 10_000 && error(mapped[3], 63) < 10_000,
            "{mapped:?}"
        );
        assert!(error(clock.latest_ns, 9) < 10_000);
    }

    #[test]
    fn a_drift_is_followed() {
        let mut clock = StampClock::default();
        // The robot's clock is slow by 50 ppm, and every message takes 2 to 4 ms.
        for k in 0..30_000_i64 {
            let sent_ns = k * 20 * MS;
            let stamp_ns = 1 + sent_ns - sent_ns / 20_000;
            let arrived_ns = sent_ns + 2 * MS + (k * 7_919 % 2_000) * 1_000;
            let error_ns = clock.on_run(stamp_ns, arrived_ns) - (sent_ns + 2 * MS);
            assert!(k < 1_000 || error_ns.abs() < MS / 2, "{k}: {error_ns}");
        }
    }

    #[test]
    fn a_clock_that_is_set_starts_anew() {
        let mut clock = StampClock::default();
        assert_eq!(clock.on_run(5 * MS, 10 * MS), 10 * MS);
        assert_eq!(clock.on_run(100_000 * MS, 30 * MS), 30 * MS);
        assert_eq!(clock.on_run(100_020 * MS, 50 * MS), 50 * MS);
        assert_eq!(clock.on_run(0, 60 * MS), 60 * MS);
    }
}
