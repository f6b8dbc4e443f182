//! Reads a recording of any supported form.

use std::io::Read;
use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

use crate::bag::open_file;
use crate::csv_folder::spool_folder;
use crate::error::Result;
use crate::foreign_bag::{Open, TopicMap, read_foreign};
use crate::import::{Import, Spooled};
use crate::mcap_file::read_own;

/// Reads a recording: a folder of CSV files, an MCAP file that slipstream wrote, or a ROS 2 bag of
/// another robot (a file, or a folder with one MCAP file). The topics of a foreign bag are guessed;
/// the guess is in the warnings.
///
/// # Errors
/// If it is none of these, cannot be read, or violates its format.
pub fn read(path: &Path) -> Result<Import> {
    read_mapped(path, None)
}

/// As [`read`]. With a map, an MCAP file is read as a bag of another robot according to the map.
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
    if metadata.is_dir() {
        return match bag_in_folder(path)? {
            Some(bag) => read_spooled(&bag, map),
            None => spool_folder(path),
        };
    }
    read_file(&|| open_file(path), path, map)
}

/// As [`read_mapped`], from the content of an MCAP file. `path` is used in errors and for the
/// recording's name only.
///
/// # Errors
/// As [`read_mapped`].
pub fn read_mapped_from(content: &[u8], path: &Path, map: Option<&TopicMap>) -> Result<Import> {
    read_file(&|| Ok((content, content.len() as u64)), path, map)?.load()
}

/// Reads an MCAP file that `open` opens, as often as needed, with its size (bytes).
fn read_file<R: Read>(open: &Open<'_, R>, path: &Path, map: Option<&TopicMap>) -> Result<Spooled> {
    if map.is_none() {
        let (source, size) = open()?;
        if let Some(import) = read_own(source, size, path)? {
            return Ok(import);
        }
    }
    read_foreign(open, path, map)
}

/// The only MCAP file of a folder without `recording.toml`; ROS 2 stores a bag as such a folder,
/// with a `metadata.yaml`. `None` for a folder of CSV files.
fn bag_in_folder(folder: &Path) -> std::result::Result<Option<PathBuf>, InputError> {
    if folder.join("recording.toml").exists() {
        return Ok(None);
    }
    let unreadable = |e| InputError::unreadable(folder, &e);
    let mut bags = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path
            .extension()
            .is_some_and(|extension| extension == "mcap")
        {
            bags.push(path);
        }
    }
    match bags.len() {
        1 => Ok(bags.pop()),
        0 => {
            let problem = "contains neither recording.toml nor an MCAP file";
            let remedy = "give a folder of CSV files with recording.toml, or an MCAP file";
            Err(InputError::file(folder, problem, remedy))
        }
        count => {
            let problem = format!("contains {count} MCAP files");
            Err(InputError::file(folder, problem, "give one of them"))
        }
    }
}
