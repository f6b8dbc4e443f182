//! Cells of one column: numbers, or counts.

/// Cells of one column, owned.
#[derive(Debug, Clone)]
pub(crate) enum Cells {
    /// Numbers; NaN if empty.
    Numbers(Vec<f64>),
    /// Whole numbers; `None` if empty.
    Counts(Vec<Option<i64>>),
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
        if column.starts_with("ticks_") {
            Self::Counts(Vec::new())
        } else {
            Self::Numbers(Vec::new())
        }
    }

    /// The numbers; empty for a column of counts.
    pub(super) fn into_numbers(self) -> Vec<f64> {
        match self {
            Self::Numbers(numbers) => numbers,
            Self::Counts(_) => Vec::new(),
        }
    }

    /// The counts; empty for a column of numbers.
    pub(super) fn into_counts(self) -> Vec<Option<i64>> {
        match self {
            Self::Counts(counts) => counts,
            Self::Numbers(_) => Vec::new(),
        }
    }
}

/// The number in a row; NaN if there is none.
pub(crate) fn number_at(numbers: &[f64], row: usize) -> f64 {
    numbers.get(row).copied().unwrap_or(f64::NAN)
}

/// An infinite number in a message counts as an empty cell, as NaN does.
pub(crate) fn finite_or_nan(number: f64) -> f64 {
    if number.is_finite() { number } else { f64::NAN }
}
