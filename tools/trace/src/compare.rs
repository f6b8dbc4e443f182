//! Comparison of two runs: which stage's mean latency differs (normal interval for large samples, variances
//! not pooled).
//!
//! Means are compared because they add up along the chain, which percentiles do not. The interval
//! assumes that the messages of a run are independent of each other. The clock of a host can be wrong by
//! the same amount for all of them: the interval is wider by what the clocks of both runs leave open.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::chain::{Chain, Fate, Link, STAGES, messages};
use crate::log::Log;
use crate::names::Names;
use crate::uncertainty::Uncertainty;

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
    pub stages: Vec<LatencyChange>,
}

/// One stage of a link in both runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LatencyChange {
    /// Its name.
    pub stage: Cow<'static, str>,
    /// Its mean in this run (s).
    pub mean_s: f64,
    /// Its mean in the other run (s).
    pub other_mean_s: f64,
    /// This run's mean minus the other's (s).
    pub difference_s: f64,
    /// 95 % confidence interval of the difference (s), wider to both sides by what the clocks of several hosts leave
    /// open of both means; `None` if it is not known how wrong a clock can be.
    pub ci95_s: Option<[f64; 2]>,
    /// Whether the interval excludes 0: a difference that the clocks alone may cause is no change.
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

/// The durations of a chain (ns), and by how much they can be wrong. Both ends of the whole chain are on
/// the clock of the plant's host.
fn durations_ns(chain: &Chain) -> Stages<(i64, Uncertainty)> {
    let end_to_end = (chain.end_to_end_ns(), Uncertainty::Exact);
    let [a, b, c, d, e, f, g] = chain.stages_ns();
    let [i, j, k, l, m, n, o] = chain.uncertainty;
    let stages = [(a, i), (b, j), (c, k), (d, l), (e, m), (f, n), (g, o)];
    let [a, b, c, d, e, f, g] = stages;
    [a, b, c, d, e, f, g, end_to_end]
}

/// The complete chains, link by link in the order of sending.
fn used(log: &Log) -> impl Iterator<Item = (Link, Stages<(i64, Uncertainty)>)> {
    messages(log).filter_map(|message| match message.fate {
        Fate::Used(chain) => Some((message.link(), durations_ns(&chain))),
        _ => None,
    })
}

/// The means of each link with at least two complete chains, in two visits of all messages.
fn means(log: &Log) -> BTreeMap<Link, Stages<Mean>> {
    let mut sums: BTreeMap<Link, Stages<DurationSum>> = BTreeMap::new();
    for (link, durations) in used(log) {
        for (sum, (ns, uncertainty)) in sums.entry(link).or_default().iter_mut().zip(durations) {
            sum.add(ns, uncertainty);
        }
    }
    for (link, durations) in used(log) {
        for (sum, (ns, _)) in sums.entry(link).or_default().iter_mut().zip(durations) {
            sum.add_square(ns);
        }
    }
    let means = sums.into_iter().filter(|(_, [first, ..])| first.count > 1);
    means
        .map(|(link, sums)| (link, sums.map(|sum| sum.mean())))
        .collect()
}

fn changes(here: &Stages<Mean>, other: &Stages<Mean>) -> Vec<LatencyChange> {
    let names = STAGES.into_iter().chain(["end_to_end"]);
    let both = names.zip(here.iter().zip(other));
    both.map(|(stage, (here, other))| change(stage, *here, *other))
        .collect()
}

fn change(stage: &'static str, this: Mean, other: Mean) -> LatencyChange {
    let difference_s = this.mean_s - other.mean_s;
    let sampling_s =
        NORMAL_QUANTILE_975 * (this.error_variance_s2 + other.error_variance_s2).sqrt();
    let clocks_s = this.uncertainty.plus(other.uncertainty).seconds();
    let half_s = clocks_s.map(|clocks_s| sampling_s + clocks_s);
    let ci95_s = half_s.map(|half_s| [difference_s - half_s, difference_s + half_s]);
    LatencyChange {
        stage: stage.into(),
        mean_s: this.mean_s,
        other_mean_s: other.mean_s,
        difference_s,
        ci95_s,
        changed: ci95_s.is_some_and(|[low, high]| low > 0.0 || high < 0.0),
    }
}

/// A mean, the variance of its error, and by how much clocks can make it wrong.
#[derive(Debug, Clone, Copy)]
struct Mean {
    mean_s: f64,
    error_variance_s2: f64,
    uncertainty: Uncertainty,
}

/// Durations being summed up: first all of them, then their squared deviations from the mean.
#[derive(Debug, Clone, Copy, Default)]
struct DurationSum {
    count: u64,
    sum_ns: i128,
    squares_s2: f64,
    /// The sum of all.
    uncertainty: Uncertainty,
}

impl DurationSum {
    fn add(&mut self, duration_ns: i64, uncertainty: Uncertainty) {
        self.count += 1;
        self.sum_ns += i128::from(duration_ns);
        self.uncertainty = self.uncertainty.plus(uncertainty);
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
            uncertainty: match self.uncertainty {
                Uncertainty::Within(ns) => Uncertainty::Within((ns as f64 / n).ceil() as i64),
                other => other,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean_of(durations_ns: [i64; 3]) -> Mean {
        let mut sum = DurationSum::default();
        durations_ns
            .iter()
            .for_each(|ns| sum.add(*ns, Uncertainty::Exact));
        durations_ns.iter().for_each(|ns| sum.add_square(*ns));
        sum.mean()
    }

    #[test]
    fn the_interval_is_the_textbook_one() {
        let (this, other) = (mean_of([4, 6, 8]), mean_of([1, 2, 3]));
        let change = change("compute", this, other);
        // Variances 4 and 1, three of each: 1.96 √(5/3) around 4.
        let half = 1.96 * (5.0_f64 / 3.0).sqrt();
        for (found, ns) in change.ci95_s.unwrap().iter().zip([4.0 - half, 4.0 + half]) {
            assert!((found * 1e9 - ns).abs() < 1e-6, "{found} {ns}");
        }
        assert!(change.changed);
        assert!(!super::change("compute", other, other).changed);
    }

    /// Two means 4 ns apart with a sampling interval of ±1.96 √(5/3) ns, which is 2.53 ns.
    #[test]
    fn clocks_widen_the_interval_by_the_sum_of_both_runs() {
        let with = |mean: Mean, uncertainty| Mean {
            uncertainty,
            ..mean
        };
        let (this, other) = (mean_of([4, 6, 8]), mean_of([1, 2, 3]));
        let [low, high] = change("transport", this, other).ci95_s.unwrap();
        for (here, there, changed) in [(1, 0, true), (0, 1, true), (1, 1, false), (2, 0, false)] {
            let [this, other] = [(this, here), (other, there)]
                .map(|(mean, ns)| with(mean, Uncertainty::Within(ns)));
            let change = change("transport", this, other);
            let wider_s = (here + there) as f64 / 1e9;
            let [wider_low, wider_high] = change.ci95_s.unwrap();
            assert!((wider_low - (low - wider_s)).abs() < 1e-18);
            assert!((wider_high - (high + wider_s)).abs() < 1e-18);
            assert_eq!(change.changed, changed, "{here} {there}");
        }
        let change = change("transport", this, with(other, Uncertainty::Unknown));
        assert_eq!((change.ci95_s, change.changed), (None, false));
    }
}
