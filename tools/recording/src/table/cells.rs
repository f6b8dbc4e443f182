//! Cells of one column: numbers, counts, or names.

use std::ops::Range;

/// Cells of one column, owned.
#[derive(Debug, Clone)]
pub(crate) enum Cells {
    /// Numbers; NaN if empty.
    Numbers(Vec<f64>),
    /// Whole numbers; `None` if empty.
    Counts(Vec<Option<i64>>),
    /// Names of robots.
    Texts(Vec<String>),
}

/// Cells of one column, borrowed.
#[derive(Debug, Clone, Copy)]
pub(crate) enum CellsView<'a> {
    /// Numbers; NaN if empty.
    Numbers(&'a [f64]),
    /// Whole numbers; `None` if empty.
    Counts(&'a [Option<i64>]),
}

impl Cells {
    /// An empty list of the type that the column holds.
    pub(crate) fn new(column: &str) -> Self {
        match column {
            "ticks_right" | "ticks_left" | "seq" => Self::Counts(Vec::new()),
            "from" | "to" => Self::Texts(Vec::new()),
            _ => Self::Numbers(Vec::new()),
        }
    }

    /// Appends a number, of counts a whole one; NaN is empty.
    pub(crate) fn push_number(&mut self, number: f64) {
        match self {
            Self::Numbers(cells) => cells.push(number),
            Self::Counts(cells) => cells.push(number.is_finite().then_some(number as i64)),
            Self::Texts(_) => {}
        }
    }

    /// Removes all cells.
    pub(super) fn clear(&mut self) {
        match self {
            Self::Numbers(cells) => cells.clear(),
            Self::Counts(cells) => cells.clear(),
            Self::Texts(cells) => cells.clear(),
        }
    }

    /// Makes room for this many cells.
    pub(super) fn reserve(&mut self, count: usize) {
        match self {
            Self::Numbers(cells) => cells.reserve_exact(count),
            Self::Counts(cells) => cells.reserve_exact(count),
            Self::Texts(cells) => cells.reserve_exact(count),
        }
    }

    /// Appends all cells of another column of the same type.
    pub(super) fn extend_from(&mut self, other: &Self) {
        match (self, other) {
            (Self::Numbers(cells), Self::Numbers(other)) => cells.extend_from_slice(other),
            (Self::Counts(cells), Self::Counts(other)) => cells.extend_from_slice(other),
            (Self::Texts(cells), Self::Texts(other)) => cells.extend_from_slice(other),
            _ => {}
        }
    }

    /// Appends a cell of another column of the same type.
    pub(super) fn push_from(&mut self, other: &Self, row: usize) {
        match (self, other) {
            (Self::Numbers(cells), Self::Numbers(other)) => cells.extend(other.get(row)),
            (Self::Counts(cells), Self::Counts(other)) => cells.extend(other.get(row)),
            (Self::Texts(cells), Self::Texts(other)) => cells.extend(other.get(row).cloned()),
            _ => {}
        }
    }

    /// The numbers; empty for a column of another type.
    pub(super) fn into_numbers(self) -> Vec<f64> {
        match self {
            Self::Numbers(numbers) => numbers,
            Self::Counts(_) | Self::Texts(_) => Vec::new(),
        }
    }

    /// The counts; empty for a column of another type.
    pub(super) fn into_counts(self) -> Vec<Option<i64>> {
        match self {
            Self::Counts(counts) => counts,
            Self::Numbers(_) | Self::Texts(_) => Vec::new(),
        }
    }
}

/// The items of a range as far as they exist.
pub(super) fn part<'a, T>(items: &'a [T], range: &Range<usize>) -> &'a [T] {
    let end = range.end.min(items.len());
    items.get(range.start.min(end)..end).unwrap_or_default()
}

/// The number in a row; NaN if there is none.
pub(crate) fn number_at(numbers: &[f64], row: usize) -> f64 {
    numbers.get(row).copied().unwrap_or(f64::NAN)
}

/// An integer for each number, in the order of [`f64::total_cmp`].
pub(crate) fn total_order(number: f64) -> i64 {
    let bits = number.to_bits().cast_signed();
    bits ^ ((bits >> 63).cast_unsigned() >> 1).cast_signed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn total_order_is_that_of_the_standard_library() {
        let numbers = [
            -f64::INFINITY,
            -2.0,
            -1e-310,
            -0.0,
            0.0,
            1e-310,
            0.5,
            f64::MAX,
            f64::NAN,
        ];
        for a in numbers {
            for b in numbers {
                assert_eq!(total_order(a).cmp(&total_order(b)), a.total_cmp(&b));
            }
        }
    }
}
