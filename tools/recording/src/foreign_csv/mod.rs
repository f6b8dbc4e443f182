//! Text files of others, read with a map of their columns, which may be guessed.

mod clock;
mod column_map;
mod draft;
mod entry;
mod guess;
mod layout;
mod lines;
mod map_text;
mod moment;
mod reader;
mod stream_table;
mod table;
mod text;
mod times_file;

pub use column_map::ColumnMap;
pub(crate) use draft::{Draft, csv_files};
pub(crate) use reader::read_columns;
pub(crate) use text::is_text;
