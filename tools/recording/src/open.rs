//! Any recording, whatever form it has.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use crate::csv_in::{Import, read_folder};
use crate::error::{Result, Unusable};
use crate::mcap_in::read_own;

/// How much of a file is read at a time (bytes).
const BUFFER: usize = 1 << 18;

/// Reads a recording: a folder of CSV files, or an MCAP file.
///
/// # Errors
/// When it is neither, or something in it is unusable.
pub fn read(path: &Path) -> Result<Import> {
    let metadata = std::fs::metadata(path).map_err(|e| Unusable::unreadable(path, &e))?;
    if metadata.is_dir() {
        return read_folder(path);
    }
    let file = File::open(path).map_err(|e| Unusable::unreadable(path, &e))?;
    let source = BufReader::with_capacity(BUFFER, file);
    match read_own(source, metadata.len(), path)? {
        (Some(import), _) => Ok(import),
        (None, _) => Err(Unusable::new(path, "no file of slipstream", "give one").into()),
    }
}
