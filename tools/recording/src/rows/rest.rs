//! The rows of a spool that are not needed yet.

use super::cursor::Rows;
use super::disk::Disk;
use super::spool::Spool;

/// The number of rows whose times are not after `t_s`, of rows that are sorted.
pub(crate) fn rows_until(spool: &Spool, t_s: f64) -> usize {
    let mut count = 0;
    spool.visit_times(&mut |times| count += times.iter().filter(|own| **own <= t_s).count());
    count
}

/// The rows after the first `passed`, on another disk.
pub(crate) fn rows_after(spool: &Spool, passed: usize, disk: &Disk) -> Spool {
    let mut rest = Spool::new(disk, spool.empty());
    let mut cursor = Rows::of_spool(spool).row_cursor();
    let mut row = 0;
    while let Some((table, at)) = cursor.row() {
        if row >= passed {
            rest.push_from(table, at);
        }
        row += 1;
        cursor.advance();
    }
    rest
}
