//! Comparison of two runs: which stage's mean latency differs (normal interval for large samples, variances
//! not pooled).
//!
//! Means are compared because they add up along the chain, which percentiles do not. The interval
//! assumes that the messages of a run are independent of each other.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::chain::{Chain, Fate, Link, STAGES, messages};
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
    let (here, mut there) = (means(log), means(other));
    let hop = |(link, stages): (Link, Stages<Mean>)| {
        let other = there.remove(&link)?;
        Some(HopChange {
            from: names.of(link.0),
            to: names.of(link.1),
            stages: changes(&stages, &other),
        })
    };
    here.into_iter().filter_map(hop).collect()
}

/// One value for each stage, then that for the whole chain.
type Stages<T> = [T; 8];

/// The durations of a chain (ns).
fn durations_ns(chain: &Chain) -> Stages<i64> {
    let [a, b, c, d, e, f, g] = chain.stages_ns();
    [a, b, c, d, e, f, g, chain.end_to_end_ns()]
}

/// The complete chains, link by link in the order of sending.
fn used(log: &Log) -> impl Iterator<Item = (Link, Stages<i64>)> {
    messages(log).filter_map(|message| match message.fate {
        Fate::Used(chain) => Some((message.link(), durations_ns(&chain))),
        _ => None,
    })
}

/// The means of each link with at least two complete chains, in two visits of all messages.
fn means(log: &Log) -> BTreeMap<Link, Stages<Mean>> {
    let mut sums: BTreeMap<Link, Stages<Sum>> = BTreeMap::new();
    for (link, durations_ns) in used(log) {
        for (sum, duration_ns) in sums.entry(link).or_default().iter_mut().zip(durations_ns) {
            sum.add(duration_ns);
        }
    }
    for (link, durations_ns) in used(log) {
        for (sum, duration_ns) in sums.entry(link).or_default().iter_mut().zip(durations_ns) {
            sum.add_square(duration_ns);
        }
    }
    let means = sums.into_iter().filter(|(_, [first, ..])| first.count > 1);
    means
        .map(|(link, sums)| (link, sums.map(|sum| sum.mean())))
        .collect()
}

fn changes(here: &Stages<Mean>, other: &Stages<Mean>) -> Vec<Change> {
    let names = STAGES.into_iter().chain(["end_to_end"]);
    let both = names.zip(here.iter().zip(other));
    both.map(|(stage, (here, other))| change(stage, *here, *other))
        .collect()
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

/// Durations being summed up: first all of them, then their squared deviations from the mean.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    count: u64,
    sum_ns: i128,
    squares_s2: f64,
}

impl Sum {
    fn add(&mut self, duration_ns: i64) {
        self.count += 1;
        self.sum_ns += i128::from(duration_ns);
    }

    fn add_square(&mut self, duration_ns: i64) {
        self.squares_s2 += (duration_ns as f64 / 1e9 - self.mean_s()).powi(2);
    }

    fn mean_s(&self) -> f64 {
        self.sum_ns as f64 / self.count as f64 / 1e9
    }

    /// The mean of at least two durations.
    fn mean(&self) -> Mean {
        let n = self.count as f64;
        Mean {
            mean_s: self.mean_s(),
            error_variance_s2: self.squares_s2 / (n - 1.0) / n,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean_of(durations_ns: [i64; 3]) -> Mean {
        let mut sum = Sum::default();
        durations_ns.iter().for_each(|ns| sum.add(*ns));
        durations_ns.iter().for_each(|ns| sum.add_square(*ns));
        sum.mean()
    }

    #[test]
    fn the_interval_is_the_textbook_one() {
        let (this, other) = (mean_of([4, 6, 8]), mean_of([1, 2, 3]));
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
