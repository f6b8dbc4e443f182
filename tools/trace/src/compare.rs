//! Comparison of two runs: which stage's mean latency differs (normal interval for large samples, variances
//! not pooled).
//!
//! Means are compared because they add up along the chain, which percentiles do not. The interval
//! assumes that the messages of a run are independent of each other.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::chain::{Chain, Fate, Link, STAGES, by_link, follow};
use crate::log::Log;
use crate::names::Names;

/// The 0.975 quantile of the standard normal distribution, rounded to two decimals as in published
/// tables: half the width of a 95 % interval in standard deviations.
const NORMAL_QUANTILE_975: f64 = 1.96;

/// One link in both runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HopChange {
    /// The sender.
    pub from: String,
    /// The receiver.
    pub to: String,
    /// The stages in the order of the chain, then `end_to_end`.
    pub stages: Vec<Change>,
}

/// One stage of a link in both runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Its name.
    pub stage: Cow<'static, str>,
    /// Its mean in this run (s).
    pub mean_s: f64,
    /// Its mean in the other run (s).
    pub other_mean_s: f64,
    /// This run's mean minus the other's (s).
    pub difference_s: f64,
    /// 95 % confidence interval of the difference (s).
    pub ci95_s: [f64; 2],
    /// Whether the interval excludes 0.
    pub changed: bool,
}

/// Compares every link that has at least two used messages in both runs; `names` by the robots' index.
pub fn against(log: &Log, other: &Log, names: &[String]) -> Vec<HopChange> {
    let names = Names(names);
    let (here, mut there) = (used(log), used(other));
    let hop = |(link, chains): (Link, Vec<Chain>)| {
        let other = there.remove(&link)?;
        (chains.len() > 1 && other.len() > 1).then(|| HopChange {
            from: names.of(link.0),
            to: names.of(link.1),
            stages: changes(&chains, &other),
        })
    };
    here.into_iter().filter_map(hop).collect()
}

/// The complete chains of each link.
fn used(log: &Log) -> BTreeMap<Link, Vec<Chain>> {
    by_link(
        follow(log)
            .into_iter()
            .filter_map(|message| match message.fate {
                Fate::Used(chain) => Some((message.link(), chain)),
                _ => None,
            }),
    )
}

fn changes(chains: &[Chain], other: &[Chain]) -> Vec<Change> {
    let both = |stage: &'static str, duration_ns: &dyn Fn(&Chain) -> i64| {
        let mean =
            |chains: &[Chain]| Mean::new(&chains.iter().map(duration_ns).collect::<Vec<i64>>());
        change(stage, mean(chains), mean(other))
    };
    let stages = STAGES.iter().enumerate();
    let mut changes: Vec<Change> = stages
        .map(|(i, &stage)| both(stage, &|chain| chain.stages_ns()[i]))
        .collect();
    changes.push(both("end_to_end", &Chain::end_to_end_ns));
    changes
}

fn change(stage: &'static str, this: Mean, other: Mean) -> Change {
    let difference_s = this.mean_s - other.mean_s;
    let half_s = NORMAL_QUANTILE_975 * (this.error_variance_s2 + other.error_variance_s2).sqrt();
    let ci95_s = [difference_s - half_s, difference_s + half_s];
    Change {
        stage: stage.into(),
        mean_s: this.mean_s,
        other_mean_s: other.mean_s,
        difference_s,
        ci95_s,
        changed: ci95_s[0] > 0.0 || ci95_s[1] < 0.0,
    }
}

/// A mean and the variance of its error.
#[derive(Debug, Clone, Copy)]
struct Mean {
    mean_s: f64,
    error_variance_s2: f64,
}

impl Mean {
    /// The mean of at least two durations (ns).
    fn new(durations_ns: &[i64]) -> Self {
        let n = durations_ns.len() as f64;
        let sum: i128 = durations_ns.iter().copied().map(i128::from).sum();
        let mean_s = sum as f64 / n / 1e9;
        let square = |&ns: &i64| (ns as f64 / 1e9 - mean_s).powi(2);
        let variance_s2 = durations_ns.iter().map(square).sum::<f64>() / (n - 1.0);
        Self {
            mean_s,
            error_variance_s2: variance_s2 / n,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_the_textbook_one() {
        let (this, other) = (Mean::new(&[4, 6, 8]), Mean::new(&[1, 2, 3]));
        let change = change("compute", this, other);
        // Variances 4 and 1, three of each: 1.96 √(5/3) around 4.
        let half = 1.96 * (5.0_f64 / 3.0).sqrt();
        for (found, ns) in change.ci95_s.iter().zip([4.0 - half, 4.0 + half]) {
            assert!((found * 1e9 - ns).abs() < 1e-6, "{found} {ns}");
        }
        assert!(change.changed);
        assert!(!super::change("compute", other, other).changed);
    }
}
