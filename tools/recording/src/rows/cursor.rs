//! A stream to read, block by block or row by row.

use super::block::BLOCK_ROWS;
use super::spool::Spool;
use crate::recording::{Links, Robot, RoundTrips};
use crate::table::{StreamKind, Table, TableView, link_block, round_trip_block};

/// A stream to read.
#[derive(Debug, Clone)]
pub(crate) struct Rows<'a> {
    source: RowSource<'a>,
    /// The columns, without rows.
    empty: Table,
}

/// Where the rows are.
#[derive(Debug, Clone)]
enum RowSource<'a> {
    Spool(&'a Spool),
    Stream(TableView<'a>),
    Links(&'a Links),
    RoundTrips(&'a RoundTrips),
}

impl<'a> Rows<'a> {
    /// The rows of a spool.
    pub(crate) fn of_spool(spool: &'a Spool) -> Self {
        Self {
            source: RowSource::Spool(spool),
            empty: spool.empty(),
        }
    }

    /// The robot's stream of this kind, if it has one.
    pub(crate) fn of_robot(robot: &'a Robot, kind: StreamKind) -> Option<Self> {
        let view = TableView::of(robot, kind)?;
        Some(Self {
            empty: view.empty(),
            source: RowSource::Stream(view),
        })
    }

    /// The position messages.
    pub(super) fn of_links(links: &'a Links) -> Self {
        Self {
            source: RowSource::Links(links),
            empty: Table::of_links(&links.unknown),
        }
    }

    /// The round trips.
    pub(super) fn of_round_trips(trips: &'a RoundTrips) -> Self {
        Self {
            source: RowSource::RoundTrips(trips),
            empty: Table::of_round_trips(&trips.unknown),
        }
    }

    /// The columns, without rows.
    pub(crate) fn empty(&self) -> &Table {
        &self.empty
    }

    /// Whether the stream has this column.
    pub(crate) fn has(&self, column: &str) -> bool {
        self.empty.columns.iter().any(|(name, _)| *name == column)
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        match &self.source {
            RowSource::Spool(spool) => spool.len(),
            RowSource::Stream(view) => view.t_s.len(),
            RowSource::Links(links) => links.messages.len(),
            RowSource::RoundTrips(trips) => trips.seq.len(),
        }
    }

    /// First and last time (s); `None` without rows.
    pub(crate) fn span_s(&self) -> Option<[f64; 2]> {
        match &self.source {
            RowSource::Spool(spool) => spool.span_s(),
            RowSource::Stream(view) => Some([*view.t_s.first()?, *view.t_s.last()?]),
            RowSource::Links(links) => {
                let messages = &links.messages;
                Some([messages.first()?.t_sent_s, messages.last()?.t_sent_s])
            }
            RowSource::RoundTrips(_) => None,
        }
    }

    /// Calls `visit` with the times of one part of the stream after the other (s).
    pub(crate) fn visit_times(&self, visit: &mut dyn FnMut(&[f64])) {
        match &self.source {
            RowSource::Spool(spool) => spool.visit_times(visit),
            RowSource::Stream(view) => visit(view.t_s),
            RowSource::Links(_) | RowSource::RoundTrips(_) => {
                let mut cursor = self.clone().cursor();
                while let Some(block) = cursor.next_block() {
                    visit(&block.t_s);
                }
            }
        }
    }

    /// A cursor before the first block.
    pub(crate) fn cursor(self) -> BlockCursor<'a> {
        BlockCursor {
            source: self.source,
            next: 0,
            block: self.empty,
            bytes: Vec::new(),
        }
    }

    /// A cursor at the first row.
    pub(crate) fn row_cursor(self) -> RowCursor<'a> {
        let mut blocks = self.cursor();
        let has_row = blocks.next_block().is_some();
        RowCursor {
            blocks,
            row: 0,
            has_row,
        }
    }
}

/// Reads a stream block by block.
#[derive(Debug)]
pub(crate) struct BlockCursor<'a> {
    source: RowSource<'a>,
    /// Index of the next block.
    next: usize,
    block: Table,
    /// The encoded block; kept to save allocations.
    bytes: Vec<u8>,
}

impl BlockCursor<'_> {
    /// The next block, which has at least one row.
    pub(crate) fn next_block(&mut self) -> Option<&Table> {
        let first = self.next.saturating_mul(BLOCK_ROWS);
        let rows = first..first.saturating_add(BLOCK_ROWS);
        let (next, block) = (self.next, &mut self.block);
        self.next += 1;
        let is_there = match &self.source {
            RowSource::Spool(spool) => spool.read_block(next, &mut self.bytes, block),
            RowSource::Stream(view) => view.block(rows, block),
            RowSource::Links(links) => link_block(links, rows, block),
            RowSource::RoundTrips(trips) => round_trip_block(trips, rows, block),
        };
        is_there.then_some(&self.block)
    }
}

/// Reads a stream row by row.
#[derive(Debug)]
pub(crate) struct RowCursor<'a> {
    blocks: BlockCursor<'a>,
    row: usize,
    has_row: bool,
}

impl RowCursor<'_> {
    /// The current row: a table and the row's index in it. `None` after the last row.
    pub(crate) fn row(&self) -> Option<(&Table, usize)> {
        self.has_row.then_some((&self.blocks.block, self.row))
    }

    /// Goes to the next row.
    pub(crate) fn advance(&mut self) {
        self.row += 1;
        if self.row >= self.blocks.block.t_s.len() {
            self.row = 0;
            self.has_row = self.has_row && self.blocks.next_block().is_some();
        }
    }
}
