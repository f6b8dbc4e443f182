//! Any recording, whatever form it has.

use std::path::Path;

use crate::csv_in::{Import, read_folder};
use crate::error::{Result, Unusable};
use crate::mcap_in::read_own;

/// Reads a recording: a folder of CSV files, or an MCAP file.
///
/// # Errors
/// When it is neither, or something in it is unusable.
pub fn read(path: &Path) -> Result<Import> {
    let metadata = std::fs::metadata(path).map_err(|e| Unusable::unreadable(path, &e))?;
    if metadata.is_dir() {
        return read_folder(path);
    }
    match read_own(path)? {
        Some(import) => Ok(import),
        None => Err(Unusable::new(path, "no file of slipstream", "give one").into()),
    }
}
