//! Any recording, whatever form it has.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use crate::csv_in::{Import, read_folder};
use crate::error::{Result, Unusable};
use crate::foreign::read_foreign;
use crate::mcap_in::read_own;
use crate::topic_map::TopicMap;

/// How much of a file is read at a time (bytes).
pub(crate) const BUFFER: usize = 1 << 18;

/// Reads a recording: a folder of CSV files, an MCAP file of ours, or another robot's ROS 2 bag,
/// whose topics are guessed (the guess is in the warnings).
///
/// # Errors
/// When it is none of these, or something in it is unusable.
pub fn read(path: &Path) -> Result<Import> {
    read_mapped(path, None)
}

/// As [`read`]. With a map, an MCAP file is read as another robot's bag by this map.
///
/// # Errors
/// As [`read`]; and when the bag does not have a topic of the map.
pub fn read_mapped(path: &Path, map: Option<&TopicMap>) -> Result<Import> {
    let metadata = std::fs::metadata(path).map_err(|e| Unusable::unreadable(path, &e))?;
    if metadata.is_dir() {
        return read_folder(path);
    }
    if map.is_some() {
        return read_foreign(path, map);
    }
    let file = File::open(path).map_err(|e| Unusable::unreadable(path, &e))?;
    let source = BufReader::with_capacity(BUFFER, file);
    match read_own(source, metadata.len(), path)? {
        Some(import) => Ok(import),
        None => read_foreign(path, None),
    }
}
