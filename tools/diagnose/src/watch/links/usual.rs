//! What the delays of a link are while nothing changes.

use statrs::distribution::{ContinuousCDF as _, Normal};

/// Delays that say what is usual, at least, and those that are kept at most.
const LEAST: usize = 20;
const MOST: usize = 4096;
/// Delays so near to the usual one (s) are the usual one: nobody feels less, and clocks and ticks are no finer.
pub(super) const FLOOR_S: f64 = 0.005;
/// A score lies within this. One message tells no more, however late it is.
const CLIP: f64 = 2.5;
/// Blocks that say something of their length.
const LEAST_BLOCKS: usize = 8;
/// Longest of these blocks (messages).
const LONGEST_BLOCK: usize = 256;
/// Variance of a median over that of a mean score.
const MEDIAN_EXCESS: f64 = std::f64::consts::FRAC_PI_2;

/// Delays of a link, as they are known.
#[derive(Debug, Clone)]
pub(super) struct Usual {
    /// In rising order, without what lies within the floor about the median (s, beside the median).
    sorted_s: Vec<f64>,
    /// The score of each of these.
    scores: Vec<f64>,
    /// The usual delay (s).
    pub(super) median_s: f64,
    /// Half the width of its 95 % interval (s).
    half_s: f64,
    /// Variance of the mean score of n messages, times n.
    pub(super) dispersion: f64,
    /// Messages on which it rests.
    messages: f64,
}

impl Usual {
    /// What the delays (s) of these runs say, each in the order of sending; `None` if they are too few.
    pub(super) fn of(runs: &[Vec<f64>]) -> Option<Self> {
        let all: Vec<f64> = runs.iter().flatten().copied().collect();
        let messages = all.len();
        let Median { at_s, half_s } = median(all.clone(), 1.0).filter(|_| messages >= LEAST)?;
        let mut sorted_s: Vec<f64> = all.iter().map(|own| beyond_floor(own - at_s)).collect();
        sorted_s.sort_by(f64::total_cmp);
        let step = messages.div_ceil(MOST);
        let sorted_s: Vec<f64> = sorted_s.into_iter().step_by(step).collect();
        let mut own = Self {
            scores: scores(&sorted_s),
            sorted_s,
            median_s: at_s,
            half_s,
            dispersion: 1.0,
            messages: messages as f64,
        };
        let scored: Vec<Vec<f64>> = runs
            .iter()
            .map(|run| run.iter().map(|delay_s| own.score(*delay_s)).collect())
            .collect();
        own.dispersion = dispersion(&scored);
        own.half_s *= own.dispersion.sqrt();
        Some(own)
    }

    /// How unusual a delay (s) is: a standard normal number while nothing changes, within [`CLIP`].
    pub(super) fn score(&self, delay_s: f64) -> f64 {
        let beside_s = beyond_floor(delay_s - self.median_s);
        let first = self.sorted_s.partition_point(|own| *own < beside_s);
        let behind = self.sorted_s.partition_point(|own| *own <= beside_s);
        if first < behind {
            return self.scores[first];
        }
        let of = |place: Option<usize>| place.and_then(|i| self.scores.get(i)).copied();
        let below = of(first.checked_sub(1)).unwrap_or(-CLIP);
        let above = of(Some(first)).unwrap_or(CLIP);
        if first == 0 {
            return -CLIP;
        }
        if first == self.sorted_s.len() {
            return CLIP;
        }
        f64::midpoint(below, above)
    }

    /// Variance of the difference between the mean score of so many messages and the usual one.
    pub(super) fn variance(&self, messages: f64) -> f64 {
        self.dispersion * (messages.recip() + self.messages.recip())
    }

    /// The 95 % interval of the usual delay (s).
    pub(super) fn interval_s(&self) -> [f64; 2] {
        [self.median_s - self.half_s, self.median_s + self.half_s]
    }

    /// The same about another median, which so many messages have shown.
    pub(super) fn moved(&self, to: Median, messages: usize) -> Self {
        Self {
            median_s: to.at_s,
            half_s: to.half_s,
            messages: (messages as f64 / MEDIAN_EXCESS).min(self.messages),
            ..self.clone()
        }
    }
}

/// A median (s) and half the width of its 95 % interval (s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Median {
    pub(super) at_s: f64,
    pub(super) half_s: f64,
}

/// The median of delays (s) by their order alone, with this dispersion; `None` without any.
pub(super) fn median(mut delays_s: Vec<f64>, dispersion: f64) -> Option<Median> {
    let last = delays_s.len().checked_sub(1)?;
    delays_s.sort_by(f64::total_cmp);
    let of = |place: f64| {
        let place = place.clamp(0.0, last as f64);
        let (low, high) = (place.floor() as usize, place.ceil() as usize);
        let share = place - place.floor();
        delays_s[low] + (delays_s[high] - delays_s[low]) * share
    };
    let (middle, count) = (last as f64 / 2.0, delays_s.len() as f64);
    let aside = 0.5 + 1.96 * (count * dispersion).sqrt() / 2.0;
    let [low_s, high_s] = [middle - aside, middle + aside].map(of);
    Some(Median {
        at_s: of(middle),
        half_s: ((high_s - low_s) / 2.0).max(LEAST_HALF_S),
    })
}

/// Times of messages are no finer (s).
const LEAST_HALF_S: f64 = 0.0005;

/// What is left of a difference (s) beyond the floor.
fn beyond_floor(apart_s: f64) -> f64 {
    apart_s.signum() * (apart_s.abs() - FLOOR_S).max(0.0)
}

/// Normal scores of the ranks of delays in rising order; equal ones have the same.
fn scores(sorted_s: &[f64]) -> Vec<f64> {
    let (normal, count) = (Normal::standard(), sorted_s.len() as f64);
    let of = |own: &f64| {
        let below = sorted_s.partition_point(|other| other < own);
        let up_to = sorted_s.partition_point(|other| other <= own);
        let rank = (below + up_to) as f64 / 2.0;
        normal.inverse_cdf(rank / count).clamp(-CLIP, CLIP)
    };
    sorted_s.iter().map(of).collect()
}

/// Variance of the sum of scores in blocks over their length: of the length at which it is largest, and no less than 1.
fn dispersion(runs: &[Vec<f64>]) -> f64 {
    let mut most = 1.0_f64;
    let mut length = 2;
    while length <= LONGEST_BLOCK {
        let blocks = runs.iter().flat_map(|run| run.chunks_exact(length));
        let squares: Vec<f64> = blocks
            .map(|block| block.iter().sum::<f64>().powi(2) / length as f64)
            .collect();
        if squares.len() < LEAST_BLOCKS {
            break;
        }
        most = most.max(squares.iter().sum::<f64>() / squares.len() as f64);
        length *= 2;
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_are_bounded_and_ties_are_usual() {
        let usual = Usual::of(&[vec![0.08; 40]]).unwrap();
        assert_eq!(usual.score(0.08), 0.0);
        assert_eq!(usual.score(0.084), 0.0);
        assert_eq!(usual.score(0.09), CLIP);
        assert_eq!(usual.score(-3.0), -CLIP);
        assert!(Usual::of(&[vec![0.08; 10]]).is_none());
        let rising: Vec<f64> = (0..200).map(|k| f64::from(k) * 1e-3).collect();
        let usual = Usual::of(&[rising]).unwrap();
        assert!((usual.median_s - 0.0995).abs() < 1e-12);
        assert!(usual.score(0.16) > 0.5 && usual.score(0.16) < 1.0);
        assert!((usual.score(0.04) + usual.score(0.159)).abs() < 1e-9);
        // they rise slowly: neighbours say the same
        assert!(usual.dispersion > 10.0);
    }

    #[test]
    fn a_median_has_an_interval_by_order() {
        let Median { at_s, half_s } = median(vec![0.3, 0.1, 0.2], 1.0).unwrap();
        assert!((at_s - 0.2).abs() < 1e-12 && (half_s - 0.1).abs() < 1e-12);
        assert!(median(Vec::new(), 1.0).is_none());
    }
}
