//! The figures of a set of durations.

use serde::Serialize;
use slipstream_bus::time::s_from_ns;

/// Percentiles by nearest rank: each is one of the durations, exact to the nanosecond.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Figures {
    /// The median (s).
    pub p50_s: f64,
    /// 99 of 100 are not above it (s).
    pub p99_s: f64,
    /// The largest (s).
    pub max_s: f64,
}

impl Figures {
    /// Of these durations (ns); `None` of none.
    pub fn new(mut durations_ns: Vec<i64>) -> Option<Self> {
        durations_ns.sort_unstable();
        let of_hundred = |percent: usize| {
            let rank = (durations_ns.len() * percent).div_ceil(100);
            durations_ns
                .get(rank.saturating_sub(1))
                .copied()
                .map(s_from_ns)
        };
        Some(Self {
            p50_s: of_hundred(50)?,
            p99_s: of_hundred(99)?,
            max_s: of_hundred(100)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_durations_that_occurred() {
        let figures = Figures::new((1..=200).rev().collect()).unwrap();
        let ns = [figures.p50_s, figures.p99_s, figures.max_s].map(|s| (s * 1e9).round());
        assert_eq!(ns, [100.0, 198.0, 200.0]);
        assert_eq!(Figures::new(vec![7]).unwrap().p50_s, 7e-9);
        assert_eq!(Figures::new(Vec::new()), None);
    }
}
