//! Streams as plain tables, so that file formats read and write columns without knowing robots.
//!
//! [`StreamKind`] lists the streams of a robot with their columns; a [`Table`] is a stream being
//! read, a [`TableView`] a stream being written.

mod cells;
mod columns;
mod kind;
mod links;
mod view;

pub(crate) use cells::{Cells, CellsView, finite_or_nan, number_at};
pub(crate) use columns::Table;
pub(crate) use kind::ColumnSet;
pub use kind::StreamKind;
pub(crate) use links::{LINK_COLUMNS, LINK_POSE_COLUMNS, ROUND_TRIP_COLUMNS};
pub(crate) use view::TableView;
