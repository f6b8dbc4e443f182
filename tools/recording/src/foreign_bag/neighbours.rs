//! Values over time, read from the first row on: for any time, the rows before and after it.

use crate::rows::{RowCursor, Rows, Spool, rows_until};
use crate::table::Table;

/// Longest time between two rows (s) between which something is interpolated.
pub(super) const MOST_GAP_S: f64 = 0.5;

/// Rows that are sorted by time, as values.
pub(super) struct Neighbours<'a, T> {
    cursor: RowCursor<'a>,
    value: fn(&Table, usize) -> T,
    before: Option<(f64, T)>,
    after: Option<(f64, T)>,
}

/// For so long (s) rows wait for those of the other that a row needs, too.
const MOST_WAIT_S: f64 = 10.0;

/// How many rows of the one at whose times values stand are of no further use, once the others are known up to `known_s`.
pub(super) fn used(rows: &Spool, known_s: f64) -> usize {
    let last_s = rows.span_s().map_or(known_s, |[_, last_s]| last_s);
    rows_until(rows, known_s.max(last_s - MOST_WAIT_S))
}

/// As [`used`], of the others: what comes next may lie between the last known row and the next one.
pub(super) fn passed(rows: &Spool, known_s: f64) -> usize {
    rows_until(rows, known_s).saturating_sub(1)
}

/// The time up to which all of several are known (s).
pub(super) fn known_until<'a>(all: impl Iterator<Item = &'a Spool>) -> f64 {
    let last_s = |rows: &Spool| {
        rows.span_s()
            .map_or(f64::NEG_INFINITY, |[_, last_s]| last_s)
    };
    all.map(last_s).fold(f64::INFINITY, f64::min)
}

/// The rows around a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Around<T> {
    pub(super) before: T,
    pub(super) after: T,
    /// The time as a share of the way between both.
    pub(super) share: f64,
    /// Time between both (s).
    pub(super) gap_s: f64,
}

impl<'a, T: Copy> Neighbours<'a, T> {
    /// Of the rows of a spool; `value` is that of a row.
    pub(super) fn new(rows: &'a Spool, value: fn(&Table, usize) -> T) -> Self {
        let mut neighbours = Self {
            cursor: Rows::of_spool(rows).row_cursor(),
            value,
            before: None,
            after: None,
        };
        neighbours.after = neighbours.here();
        neighbours
    }

    fn here(&self) -> Option<(f64, T)> {
        let (table, row) = self.cursor.row()?;
        Some((*table.t_s.get(row)?, (self.value)(table, row)))
    }

    /// Time (s) and value of the next row that was not asked for yet.
    pub(super) fn next(&mut self) -> Option<(f64, T)> {
        let next = self.after;
        self.cursor.advance();
        self.after = self.here();
        next
    }

    /// As [`next`](Self::next), if its time is not after `t_s`.
    pub(super) fn next_until(&mut self, t_s: f64) -> Option<(f64, T)> {
        self.after.filter(|(next_s, _)| *next_s <= t_s)?;
        self.next()
    }

    /// The rows around a time that is not before the last one asked for; `None` outside of the known times.
    pub(super) fn around(&mut self, t_s: f64) -> Option<Around<T>> {
        while let Some((after_s, _)) = self.after
            && after_s < t_s
        {
            self.before = self.next();
        }
        let (after_s, after) = self.after?;
        if after_s == t_s {
            return Some(Around {
                before: after,
                after,
                share: 0.0,
                gap_s: 0.0,
            });
        }
        let (before_s, before) = self.before?;
        let gap_s = after_s - before_s;
        Some(Around {
            before,
            after,
            share: (t_s - before_s) / gap_s,
            gap_s,
        })
    }
}
