//! Opens a file for reading from front to back.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use crate::error::Unusable;

/// How much of a file is read at a time (bytes).
const BUFFER_BYTES: usize = 1 << 18;

/// Opens a file and says how many bytes it has.
pub(crate) fn open(path: &Path) -> Result<(BufReader<File>, u64), Unusable> {
    let unreadable = |e: std::io::Error| Unusable::unreadable(path, &e);
    let file = File::open(path).map_err(unreadable)?;
    let size = file.metadata().map_err(unreadable)?.len();
    Ok((BufReader::with_capacity(BUFFER_BYTES, file), size))
}
