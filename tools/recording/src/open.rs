//! Reads a recording of any supported form.

use std::path::Path;

use slipstream_bus::InputError;

use crate::bag::{Bag, BagBytes, BagFile, BagFolder, Container};
use crate::csv_folder::spool_folder;
use crate::error::Result;
use crate::foreign_bag::{TopicMap, read_foreign};
use crate::import::{Import, Spooled};
use crate::mcap_file::read_own;

/// Reads a recording: a folder of CSV files; an MCAP file that slipstream wrote; or a bag of another robot, which may be
/// an MCAP file, an SQLite database or a folder of them, as ROS 2 writes it, or a ROS 1 bag. The topics of a foreign
/// bag are guessed; the guess is in the warnings.
///
/// # Errors
/// If it is none of these, cannot be read, or violates its format.
pub fn read(path: &Path) -> Result<Import> {
    read_mapped(path, None)
}

/// As [`read`]. With a map, a bag is read as one of another robot according to the map.
///
/// # Errors
/// As [`read`], or if a topic of the map does not exist or cannot provide its stream.
pub fn read_mapped(path: &Path, map: Option<&TopicMap>) -> Result<Import> {
    read_spooled(path, map)?.load()
}

/// As [`read_mapped`], for recordings of any length: the rows stay in a temporary file.
///
/// # Errors
/// As [`read_mapped`], or if the temporary file cannot be written.
pub fn read_spooled(path: &Path, map: Option<&TopicMap>) -> Result<Spooled> {
    let metadata = std::fs::metadata(path).map_err(|e| InputError::unreadable(path, &e))?;
    if !metadata.is_dir() {
        return read_file(&BagFile::open(path)?, path, map);
    }
    if path.join("recording.toml").exists() {
        return match map {
            None => spool_folder(path),
            Some(_) => Err(no_topics(path)),
        };
    }
    let Some(folder) = BagFolder::open(path)? else {
        let problem = "contains neither recording.toml nor a bag";
        let remedy = "give a folder of CSV files with recording.toml, or a bag";
        return Err(InputError::file(path, problem, remedy).into());
    };
    match folder.only_part() {
        Some(part) => read_file(part, part.path(), map),
        None => read_foreign(&folder, path, map),
    }
}

/// As [`read_mapped`], from the content of a bag file. `path` is used in errors and for the
/// recording's name only.
///
/// # Errors
/// As [`read_mapped`].
pub fn read_mapped_from(content: &[u8], path: &Path, map: Option<&TopicMap>) -> Result<Import> {
    let bag = BagBytes { content, path };
    if bag.container() == Container::Mcap
        && map.is_none()
        && let Some(import) = read_own(content, content.len() as u64, path)?
    {
        return import.load();
    }
    read_foreign(&bag, path, map)?.load()
}

/// Reads a file: one of our own, or a bag of another robot.
fn read_file(bag: &BagFile, path: &Path, map: Option<&TopicMap>) -> Result<Spooled> {
    if bag.container == Container::Mcap && map.is_none() {
        let (source, size) = bag.source()?;
        if let Some(import) = read_own(source, size, path)? {
            return Ok(import);
        }
    }
    read_foreign(bag as &dyn Bag, path, map)
}

/// A folder of CSV files has no topics.
fn no_topics(path: &Path) -> crate::Error {
    let problem = "is a folder of CSV files, which has no topics";
    InputError::file(path, problem, "leave --topics out").into()
}
