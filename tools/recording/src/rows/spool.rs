//! A stream being read, whose rows go to a temporary file block by block.

use super::block::{BLOCK_ROWS, BLOCK_TEXT_BYTES, decode, decode_numbers, encode, time_bytes};
use super::disk::Disk;
use crate::table::Table;

/// Rows of one stream. The last ones, at most [`BLOCK_ROWS`], are in memory, so that a short recording
/// needs no file; those before them are blocks on a [`Disk`]. Of these, memory holds 24 bytes each.
#[derive(Debug)]
pub(crate) struct Spool {
    disk: Disk,
    blocks: Vec<SpoolPlace>,
    /// The rows after the last block.
    tail: Table,
    /// Size of the texts in `tail`.
    text_bytes: usize,
    /// Number of rows in all blocks.
    rows: usize,
    /// First and last time so far (s).
    span_s: Option<[f64; 2]>,
    is_sorted: bool,
}

/// Where a block lies.
#[derive(Debug, Clone, Copy)]
struct SpoolPlace {
    offset: u64,
    bytes: usize,
    rows: usize,
}

impl Spool {
    /// No rows yet, with the columns of `empty`.
    pub(crate) fn new(disk: &Disk, empty: Table) -> Self {
        Self {
            disk: disk.clone(),
            blocks: Vec::new(),
            tail: empty,
            text_bytes: 0,
            rows: 0,
            span_s: None,
            is_sorted: true,
        }
    }

    /// The table to append the cells of the next row to. Call [`Spool::end_row`] after each row.
    pub(crate) fn tail(&mut self) -> &mut Table {
        &mut self.tail
    }

    /// Ends a row that was appended to [`Spool::tail`].
    pub(crate) fn end_row(&mut self) {
        let t_s = self.tail.t_s.last().copied().unwrap_or(f64::NAN);
        self.is_sorted &= self.span_s.is_none_or(|[_, last]| last <= t_s);
        self.span_s = Some([self.span_s.map_or(t_s, |[first, _]| first), t_s]);
        self.text_bytes += self.tail.text_bytes_of_last_row();
        if self.tail.t_s.len() >= BLOCK_ROWS || self.text_bytes >= BLOCK_TEXT_BYTES {
            self.write_block();
        }
    }

    /// Appends a row of numbers, one for each column.
    pub(crate) fn push_numbers(&mut self, t_s: f64, numbers: impl IntoIterator<Item = f64>) {
        self.tail.t_s.push(t_s);
        for ((_, cells), number) in self.tail.columns.iter_mut().zip(numbers) {
            cells.push_number(number);
        }
        self.end_row();
    }

    /// Appends a row of a table with the same columns.
    pub(super) fn push_from(&mut self, table: &Table, row: usize) {
        self.tail.push_from(table, row);
        self.end_row();
    }

    /// Takes all rows; what follows goes to another disk.
    pub(crate) fn take(&mut self, disk: &Disk) -> Self {
        let next = Self::new(disk, self.empty());
        std::mem::replace(self, next)
    }

    /// The time of the last row (s).
    pub(crate) fn last_t_s(&self) -> Option<f64> {
        self.span_s.map(|[_, last]| last)
    }

    /// First and last time (s).
    pub(crate) fn span_s(&self) -> Option<[f64; 2]> {
        self.span_s
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.rows + self.tail.t_s.len()
    }

    /// Whether no row is earlier than the one before it.
    pub(crate) fn is_sorted(&self) -> bool {
        self.is_sorted
    }

    /// The disk of this spool.
    pub(super) fn disk(&self) -> &Disk {
        &self.disk
    }

    /// The columns, without rows.
    pub(crate) fn empty(&self) -> Table {
        self.tail.without_rows()
    }

    /// Replaces the rows of `table`, which has the same columns, with those of block `index`. `bytes`
    /// is kept by the caller to save allocations. Returns whether there is such a block.
    pub(super) fn read_block(&self, index: usize, bytes: &mut Vec<u8>, table: &mut Table) -> bool {
        let Some(place) = self.blocks.get(index) else {
            table.clone_from(&self.tail);
            return index == self.blocks.len() && !self.tail.t_s.is_empty();
        };
        bytes.resize(place.bytes, 0);
        let is_read = self.disk.read(place.offset, bytes);
        if is_read {
            decode(bytes, place.rows, table);
        }
        is_read
    }

    /// Calls `visit` with the times of each block (s), without reading the other columns.
    pub(super) fn visit_times(&self, visit: &mut dyn FnMut(&[f64])) {
        let (mut bytes, mut times) = (Vec::new(), Vec::new());
        for place in &self.blocks {
            bytes.resize(time_bytes(place.rows), 0);
            if !self.disk.read(place.offset, &mut bytes) {
                return;
            }
            times.clear();
            decode_numbers(&bytes, &mut times);
            visit(&times);
        }
        visit(&self.tail.t_s);
    }

    fn write_block(&mut self) {
        let mut bytes = Vec::new();
        encode(&self.tail, &mut bytes);
        let rows = self.tail.t_s.len();
        self.blocks.push(SpoolPlace {
            offset: self.disk.append(&bytes),
            bytes: bytes.len(),
            rows,
        });
        self.rows += rows;
        self.tail.clear();
        self.text_bytes = 0;
    }
}
