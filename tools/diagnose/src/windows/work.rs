//! What a search has cost so far, counted in simulated time: the same on every machine.

use std::sync::atomic::{AtomicU64, Ordering};

/// Simulated time.
#[derive(Debug, Default)]
pub(crate) struct Work(AtomicU64);

impl Work {
    /// Adds `time_s` of one robot.
    pub(crate) fn add(&self, time_s: f64) {
        // whole microseconds: sums of them do not depend on their order
        self.0.fetch_add((time_s * 1e6) as u64, Ordering::Relaxed);
    }

    /// All so far (s).
    pub(crate) fn so_far_s(&self) -> f64 {
        self.0.load(Ordering::Relaxed) as f64 * 1e-6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_add_up_to_the_microsecond() {
        let work = Work::default();
        (0..1000).for_each(|_| work.add(0.25));
        work.add(3e-6);
        assert!((work.so_far_s() - 250.000_003).abs() < 1e-9);
    }
}
