//! What counters of wheels do.

use std::f64::consts::{PI, TAU};

use super::rows::{Quantity, Rows};
use crate::maker::random::RandomStream;

/// Largest part of a wrap that a counter may count from row to row, so that a person can undo the wrap even where a
/// few rows are lost.
const CLEAR_SHARE: f64 = 0.12;

/// Ranges of counters: the least count, and how many there are.
const RANGES: [[f64; 2]; 3] = [[0.0, 65_536.0], [-32_768.0, 65_536.0], [0.0, 9_000.0]];

/// The counters run in a range, the same in all runs: 16 bit with or without sign, 9000, or ±π of an angle.
pub(super) fn wrap(rows: &mut Rows, size: f64, _random: &mut RandomStream) -> bool {
    let [from, span] = match rows.quantity {
        Quantity::Counts => RANGES[((size * 3.0) as usize).min(2)],
        Quantity::Angles => [-PI, TAU],
        _ => return false,
    };
    let rises = rows.rows.windows(2);
    let most = rises.flat_map(|two| [0, 1].map(|i| (two[1].values[i] - two[0].values[i]).abs()));
    let wraps = rows.rows.iter().any(|row| {
        let outside = |value: &f64| *value < from || *value >= from + span;
        row.values[..2].iter().any(outside)
    });
    if !wraps || most.fold(0.0, f64::max) > CLEAR_SHARE * span {
        return false;
    }
    for row in &mut rows.rows {
        for value in &mut row.values[..2] {
            *value = from + (*value - from).rem_euclid(span);
        }
    }
    true
}

/// The counters begin again at zero, once in the middle.
pub(super) fn reset(rows: &mut Rows, _size: f64, random: &mut RandomStream) -> bool {
    if !counts(rows) || rows.rows.is_empty() {
        return false;
    }
    let at = (rows.rows.len() as f64 * random.uniform(0.3, 0.7)) as usize;
    let zero = rows.rows[at].values;
    for row in &mut rows.rows[at..] {
        row.values = std::array::from_fn(|i| row.values[i] - zero[i]);
    }
    true
}

/// One to three rows at a foreign value: zero, or far off.
pub(super) fn glitch(rows: &mut Rows, _size: f64, random: &mut RandomStream) -> bool {
    let all = rows.rows.len();
    if !counts(rows) || all < 10 {
        return false;
    }
    let reach = rows
        .rows
        .iter()
        .map(|row| row.values[0].abs())
        .fold(0.0, f64::max);
    let times = 1 + (3.0 * random.unit()) as usize;
    for _ in 0..times {
        let at = (all as f64 * random.uniform(0.1, 0.9)) as usize;
        let foreign = if random.bernoulli(0.5) {
            0.0
        } else {
            random.sign() * reach * random.uniform(1.0, 3.0)
        };
        rows.rows[at].values[0] = foreign.round();
        rows.rows[at].values[1] = foreign.round();
    }
    true
}

fn counts(rows: &Rows) -> bool {
    matches!(rows.quantity, Quantity::Counts | Quantity::Angles)
}

#[cfg(test)]
mod tests {
    use super::super::rows::tests::counted;
    use super::*;

    #[test]
    fn a_wrapped_counter_stays_in_its_range_and_can_be_undone() {
        let plain = counted(Quantity::Counts);
        let mut rows = counted(Quantity::Counts);
        rows.rows.iter_mut().for_each(|row| row.values[0] *= 20.0);
        let mut random = RandomStream::new(1, 0);
        assert!(wrap(&mut rows, 0.0, &mut random));
        let values = || rows.rows.iter().map(|row| row.values[0]);
        assert!(values().all(|value| value.abs() <= 65_536.0));
        assert!(
            rows.rows
                .windows(2)
                .any(|two| two[1].values[0] < two[0].values[0])
        );
        // what counts a third of the range in a row is left alone, as is what never leaves it
        let mut fast = counted(Quantity::Angles);
        assert!(!wrap(&mut fast, 0.0, &mut random));
        let mut speeds = counted(Quantity::Speeds);
        assert!(!wrap(&mut speeds, 0.0, &mut random));
        assert_eq!(speeds.rows, plain.rows);
    }

    #[test]
    fn a_reset_counter_begins_again_at_zero() {
        let mut rows = counted(Quantity::Counts);
        assert!(reset(&mut rows, 0.0, &mut RandomStream::new(1, 0)));
        let falls: Vec<f64> = rows
            .rows
            .windows(2)
            .filter(|two| two[1].values[0] < two[0].values[0])
            .map(|two| two[1].values[0])
            .collect();
        assert_eq!(falls, [0.0]);
    }

    #[test]
    fn a_glitch_is_one_to_three_rows() {
        let (plain, mut rows) = (counted(Quantity::Counts), counted(Quantity::Counts));
        assert!(glitch(&mut rows, 0.0, &mut RandomStream::new(1, 0)));
        let changed = rows
            .rows
            .iter()
            .zip(&plain.rows)
            .filter(|(a, b)| a.values != b.values)
            .count();
        assert!((1..=3).contains(&changed), "{changed}");
    }
}
