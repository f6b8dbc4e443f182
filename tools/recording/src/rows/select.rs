//! Exact selection of the number of a rank, by counting: fixed memory, a few visits of all numbers.

use crate::table::total_order;

/// Number of parts into which a visit divides the range that is left.
const PARTS: usize = 1024;

/// The search for the number of one rank among numbers that are visited several times. A visit counts
/// how many numbers lie in each part of the range; the next one divides the part of the rank.
#[derive(Debug)]
pub(crate) struct Selection {
    /// Numbers in the range that are smaller than the one searched for.
    rank: u64,
    /// Smallest and largest number of the range, as [`key`]s.
    range: [u64; 2],
    parts: Vec<RangePart>,
}

/// Number, smallest and largest of the numbers in a part of the range.
#[derive(Debug, Clone, Copy)]
struct RangePart {
    count: u64,
    low: u64,
    high: u64,
}

impl Selection {
    /// Searches for the number that `rank` numbers precede in the order of [`f64::total_cmp`].
    pub(crate) fn new(rank: u64) -> Self {
        Self {
            rank,
            range: [0, u64::MAX],
            parts: vec![RangePart::EMPTY; PARTS],
        }
    }

    /// Adds a number. Each visit adds the same ones.
    pub(crate) fn add(&mut self, number: f64) {
        let key = key(number);
        let [low, high] = self.range;
        if (low..=high).contains(&key) {
            let width = (high - low) / PARTS as u64 + 1;
            if let Some(part) = self.parts.get_mut(((key - low) / width) as usize) {
                part.count += 1;
                part.low = part.low.min(key);
                part.high = part.high.max(key);
            }
        }
    }

    /// Ends a visit. Returns the number if it is known; `None` if another visit is needed. NaN if there
    /// are not as many numbers.
    pub(crate) fn end_visit(&mut self) -> Option<f64> {
        for part in &self.parts {
            if self.rank < part.count {
                self.range = [part.low, part.high];
                if part.low == part.high {
                    return Some(number(part.low));
                }
                self.parts.fill(RangePart::EMPTY);
                return None;
            }
            self.rank -= part.count;
        }
        Some(f64::NAN)
    }
}

impl RangePart {
    const EMPTY: Self = Self {
        count: 0,
        low: u64::MAX,
        high: 0,
    };
}

/// The median (of an even number of numbers, the upper one) of `count` numbers; `None` without numbers.
/// `visit` adds them all, each time it is called.
pub(crate) fn median(count: u64, visit: &dyn Fn(&mut Selection)) -> Option<f64> {
    if count == 0 {
        return None;
    }
    let mut selection = Selection::new(count / 2);
    loop {
        visit(&mut selection);
        if let Some(median) = selection.end_visit() {
            return Some(median);
        }
    }
}

/// An unsigned integer for each number, in the same order.
fn key(number: f64) -> u64 {
    total_order(number).cast_unsigned() ^ (1 << 63)
}

/// The number with this key.
fn number(key: u64) -> f64 {
    let ordered = (key ^ (1 << 63)).cast_signed();
    let bits = ordered ^ ((ordered >> 63).cast_unsigned() >> 1).cast_signed();
    f64::from_bits(bits.cast_unsigned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted_median(mut numbers: Vec<f64>) -> f64 {
        numbers.sort_by(f64::total_cmp);
        numbers[numbers.len() / 2]
    }

    #[test]
    fn the_median_is_that_of_the_sorted_numbers_bit_for_bit() {
        let many: Vec<f64> = (0..10_000)
            .map(|i| (f64::from(i) * 0.7).sin() * 10_f64.powi(i % 600 - 300))
            .collect();
        let steps: Vec<f64> = (0..9_999)
            .map(|i| f64::from(i + 1) * 1e-3 - f64::from(i) * 1e-3)
            .collect();
        let few = vec![-0.0, 0.0, 0.0, -0.0];
        for numbers in [many, steps, few, vec![3.0], vec![1.0, 2.0, f64::NAN]] {
            let add = |selection: &mut Selection| numbers.iter().for_each(|n| selection.add(*n));
            let found = median(numbers.len() as u64, &add).unwrap();
            assert_eq!(found.to_bits(), sorted_median(numbers.clone()).to_bits());
        }
        assert_eq!(median(0, &|_| {}), None);
    }
}
