//! Recordings as folders of CSV files: one file per stream, and `recording.toml`.

mod csv_file;
mod reader;
mod writer;

pub use reader::read_folder;
pub(crate) use reader::spool_folder;
pub use writer::write_folder;
