//! Buffered sequential reading of a file.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use slipstream_bus::InputError;

/// Size of the read buffer (bytes).
const BUFFER_BYTES: usize = 1 << 18;

/// Opens a file. Returns its reader and its size (bytes).
///
/// # Errors
/// If the operating system does not open it.
pub fn open_file(path: &Path) -> Result<(BufReader<File>, u64), InputError> {
    let unreadable = |e: std::io::Error| InputError::unreadable(path, &e);
    let file = File::open(path).map_err(unreadable)?;
    let size = file.metadata().map_err(unreadable)?.len();
    Ok((BufReader::with_capacity(BUFFER_BYTES, file), size))
}
