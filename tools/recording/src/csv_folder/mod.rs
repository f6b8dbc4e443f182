//! A recording as a folder of CSV files.

mod reader;
mod rows;
mod writer;

pub use reader::read_folder;
pub use writer::write_folder;
