//! Sorting by time in bounded memory.
//!
//! No format bounds how late a message may stand in its file (a run writes a position once it has
//! arrived, a merged bag one robot after the other), so that this is an external merge sort and not
//! a window.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::cursor::{RowCursor, Rows};
use super::disk::Disk;
use super::spool::Spool;
use crate::table::total_order;

/// Number of blocks that are sorted in memory.
const RUN_BLOCKS: usize = 64;
/// Number of runs that are merged at once.
const FAN_IN: usize = 256;

/// The rows of a stream in the order of time; rows with equal times keep their order.
pub(crate) fn sorted_by_time(spool: Spool) -> Spool {
    if spool.is_sorted() {
        return spool;
    }
    let disk = spool.disk().clone();
    let mut runs = runs(&spool, &disk.sibling());
    drop(spool);
    while runs.len() > FAN_IN {
        let pass = disk.sibling();
        runs = runs.chunks(FAN_IN).map(|runs| merge(runs, &pass)).collect();
    }
    merge(&runs, &disk)
}

/// The rows cut into parts, each sorted in memory.
fn runs(spool: &Spool, disk: &Disk) -> Vec<Spool> {
    let mut runs = Vec::new();
    let mut cursor = Rows::of_spool(spool).cursor();
    loop {
        let mut part = spool.empty();
        for _ in 0..RUN_BLOCKS {
            let Some(block) = cursor.next_block() else {
                break;
            };
            (0..block.t_s.len()).for_each(|row| part.push_from(block, row));
        }
        if part.t_s.is_empty() {
            // Even a stream without rows keeps its columns.
            if runs.is_empty() {
                runs.push(Spool::new(disk, spool.empty()));
            }
            return runs;
        }
        let mut order: Vec<usize> = (0..part.t_s.len()).collect();
        order.sort_by_key(|row| part.t_s.get(*row).copied().map(total_order));
        let mut run = Spool::new(disk, spool.empty());
        order.into_iter().for_each(|row| run.push_from(&part, row));
        runs.push(run);
    }
}

/// Merges sorted parts; of rows with equal times, those of the earlier part come first.
fn merge(runs: &[Spool], disk: &Disk) -> Spool {
    let empty = runs.first().map(Spool::empty).unwrap_or_default();
    let mut merged = Spool::new(disk, empty);
    let mut cursors: Vec<RowCursor<'_>> = runs
        .iter()
        .map(|run| Rows::of_spool(run).row_cursor())
        .collect();
    let key = |cursor: &RowCursor<'_>, index| {
        let (table, row) = cursor.row()?;
        Some(Reverse((total_order(*table.t_s.get(row)?), index)))
    };
    let mut next: BinaryHeap<Reverse<(i64, usize)>> = BinaryHeap::new();
    next.extend(cursors.iter().enumerate().filter_map(|(i, c)| key(c, i)));
    while let Some(Reverse((_, index))) = next.pop() {
        let Some(cursor) = cursors.get_mut(index) else {
            continue;
        };
        if let Some((table, row)) = cursor.row() {
            merged.push_from(table, row);
        }
        cursor.advance();
        next.extend(key(cursor, index));
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::UnknownColumn;
    use crate::table::{Cells, Table};

    #[test]
    fn a_long_stream_is_sorted_and_equal_times_keep_their_order() {
        let empty = Table::new(&["x_m", "y_m"], vec![UnknownColumn::named("note")]);
        let mut spool = Spool::new(&Disk::default(), empty);
        let rows = 200_000_u64;
        for i in 0..rows {
            let table = spool.tail();
            table.t_s.push((i * 7919 % 1000) as f64);
            for (_, cells) in &mut table.columns {
                if let Cells::Numbers(cells) = cells {
                    cells.push(i as f64);
                }
            }
            table.unknown[0].cells.push(i.to_string());
            spool.end_row();
        }
        assert!(!spool.is_sorted());
        let spool = sorted_by_time(spool);
        assert!(spool.is_sorted());
        assert_eq!(spool.len() as u64, rows);
        let mut cursor = Rows::of_spool(&spool).row_cursor();
        let mut last = (-1.0, -1.0);
        while let Some((table, row)) = cursor.row() {
            let here = (table.t_s[row], table.number(0, row));
            assert!(last < here, "{last:?} {here:?}");
            assert_eq!(table.unknown[0].cells[row], format!("{}", here.1));
            assert_eq!((here.1 as u64 * 7919 % 1000) as f64, here.0);
            last = here;
            cursor.advance();
        }
        spool.disk().check().unwrap();
    }
}
