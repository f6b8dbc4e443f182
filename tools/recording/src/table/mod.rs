//! Streams as plain tables, so that file formats read and write columns without knowing robots.
//!
//! [`StreamKind`] lists the streams of a robot with their columns; a [`Table`] holds rows of a stream,
//! a [`TableView`] borrows a stream in memory.

mod cells;
mod columns;
mod kind;
mod limits;
mod links;
mod message_blocks;
mod view;

pub(crate) use cells::{Cells, number_at, total_order};
pub(crate) use columns::Table;
pub use kind::{ColumnSet, StreamKind, TIME};
pub(crate) use limits::{OutOfRange, is_time, out_of_range};
pub(crate) use links::{LINK_COLUMNS, LINK_POSE_COLUMNS, ROUND_TRIP_COLUMNS, link_columns};
pub use links::{LINKS, ROUND_TRIPS};
pub(crate) use message_blocks::{link_block, round_trip_block};
pub(crate) use view::TableView;
