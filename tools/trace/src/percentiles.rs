//! Percentiles of a set of durations, by nearest rank.

use serde::{Deserialize, Serialize};
use slipstream_bus::time::s_from_ns;

/// Percentiles by nearest rank: each is one of the durations, exact to the nanosecond.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Percentiles {
    /// Median (s).
    pub p50_s: f64,
    /// 99th percentile (s).
    pub p99_s: f64,
    /// Maximum (s).
    pub max_s: f64,
}

impl Percentiles {
    /// Percentiles of `durations_ns` (ns); `None` if there are none.
    pub fn new(mut durations_ns: Vec<i64>) -> Option<Self> {
        durations_ns.sort_unstable();
        let percentile = |percent: usize| {
            let rank = (durations_ns.len() * percent).div_ceil(100);
            durations_ns
                .get(rank.saturating_sub(1))
                .copied()
                .map(s_from_ns)
        };
        Some(Self {
            p50_s: percentile(50)?,
            p99_s: percentile(99)?,
            max_s: percentile(100)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_durations_that_occurred() {
        let found = Percentiles::new((1..=200).rev().collect()).unwrap();
        let ns = [found.p50_s, found.p99_s, found.max_s].map(|s| (s * 1e9).round());
        assert_eq!(ns, [100.0, 198.0, 200.0]);
        assert_eq!(Percentiles::new(vec![7]).unwrap().p50_s, 7e-9);
        assert_eq!(Percentiles::new(Vec::new()), None);
    }
}
