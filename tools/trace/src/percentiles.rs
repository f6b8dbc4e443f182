//! Mean and percentiles of a set of durations, these by nearest rank.

use serde::{Deserialize, Serialize};
use slipstream_bus::time::s_from_ns;

/// Mean, which adds up over stages, and percentiles by nearest rank: each is one of the durations, exact to the
/// nanosecond.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Percentiles {
    /// Mean (s).
    pub mean_s: f64,
    /// Median (s).
    pub p50_s: f64,
    /// 95th percentile (s).
    pub p95_s: f64,
    /// 99th percentile (s).
    pub p99_s: f64,
    /// Maximum (s).
    pub max_s: f64,
}

impl Percentiles {
    /// Percentiles of `durations_ns` (ns); `None` if there are none.
    pub fn new(mut durations_ns: Vec<i64>) -> Option<Self> {
        durations_ns.sort_unstable();
        Self::of_sorted(durations_ns.len() as u64, &mut durations_ns.into_iter())
    }

    /// Percentiles of the next `count` durations (ns), which are in ascending order; `None` if there
    /// are none. Takes them all.
    pub(crate) fn of_sorted(
        count: u64,
        durations_ns: &mut dyn Iterator<Item = i64>,
    ) -> Option<Self> {
        let rank = |percent: u64| count.saturating_mul(percent).div_ceil(100).max(1);
        let (mut found, mut sum_ns) = ([None; 4], 0_i128);
        for (number, duration_ns) in (1..=count).zip(durations_ns) {
            sum_ns += i128::from(duration_ns);
            for (found, percent) in found.iter_mut().zip([50, 95, 99, 100]) {
                if number == rank(percent) {
                    *found = Some(s_from_ns(duration_ns));
                }
            }
        }
        let [p50_s, p95_s, p99_s, max_s] = found;
        #[expect(
            clippy::cast_precision_loss,
            reason = "a mean needs no more than 53 bits"
        )]
        let mean_s = 1e-9 * (sum_ns as f64 / count as f64);
        Some(Self {
            mean_s,
            p50_s: p50_s?,
            p95_s: p95_s?,
            p99_s: p99_s?,
            max_s: max_s?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_durations_that_occurred() {
        let found = Percentiles::new((1..=200).rev().collect()).unwrap();
        let ns = [found.p50_s, found.p95_s, found.p99_s, found.max_s].map(|s| (s * 1e9).round());
        assert_eq!(ns, [100.0, 190.0, 198.0, 200.0]);
        assert!((found.mean_s - 100.5e-9).abs() < 1e-20);
        assert_eq!(Percentiles::new(vec![7]).unwrap().p50_s, 7e-9);
        assert_eq!(Percentiles::new(Vec::new()), None);
    }
}
