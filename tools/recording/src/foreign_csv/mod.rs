//! CSV files of others, read with a map of their columns.

mod column_map;
mod draft;
mod reader;
mod table;

pub use column_map::ColumnMap;
pub(crate) use draft::{csv_files, draft};
pub(crate) use reader::read_columns;
