//! The files of a bag that a recorder splits while it records.

use std::path::{Path, PathBuf};

use slipstream_bag::mcap_files;
use slipstream_bus::InputError;

/// The MCAP file in a folder that comes after `last`, by the numbers in their names; the first one after none.
///
/// # Errors
/// If the folder cannot be read.
pub fn next_part(folder: &Path, last: Option<&Path>) -> Result<Option<PathBuf>, InputError> {
    let files = mcap_files(folder)?;
    let place = last.and_then(|last| files.iter().position(|own| own == last));
    Ok(files.into_iter().nth(place.map_or(0, |place| place + 1)))
}
