//! Cells of one column.

/// The cells of one column.
#[derive(Debug, Clone)]
pub(crate) enum Cells {
    Numbers(Vec<f64>),
    Counts(Vec<Option<i64>>),
}

/// The cells of one column, borrowed.
#[derive(Debug, Clone, Copy)]
pub(crate) enum CellsView<'a> {
    Numbers(&'a [f64]),
    Counts(&'a [Option<i64>]),
}

/// Whether a column holds whole numbers.
pub(crate) fn is_count(column: &str) -> bool {
    column.starts_with("ticks_")
}

impl Cells {
    /// No cells yet, of the type that `column` holds.
    pub(crate) fn of(column: &str) -> Self {
        if is_count(column) {
            Self::Counts(Vec::new())
        } else {
            Self::Numbers(Vec::new())
        }
    }

    pub(super) fn numbers(self) -> Vec<f64> {
        match self {
            Self::Numbers(numbers) => numbers,
            Self::Counts(_) => Vec::new(),
        }
    }

    pub(super) fn counts(self) -> Vec<Option<i64>> {
        match self {
            Self::Counts(counts) => counts,
            Self::Numbers(_) => Vec::new(),
        }
    }
}
