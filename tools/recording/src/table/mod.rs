//! Every stream as a plain table: what the formats read and write without knowing robots.
//!
//! [`StreamKind`] lists the files of the format with their columns; [`Table`] holds one stream on
//! its way in, [`TableView`] on its way out.

mod cells;
mod columns;
mod kind;
mod links;
mod view;

pub(crate) use cells::{Cells, CellsView};
pub(crate) use columns::Table;
pub(crate) use kind::ColumnSet;
pub use kind::StreamKind;
pub(crate) use links::LINK_COLUMNS;
pub(crate) use view::TableView;
