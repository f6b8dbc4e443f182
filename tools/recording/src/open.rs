//! Any recording, whatever form it has.

use std::path::{Path, PathBuf};

use crate::bag;
use crate::csv_folder::read_folder;
use crate::error::{Result, Unusable};
use crate::foreign_bag::{TopicMap, read_foreign};
use crate::import::Import;
use crate::mcap_file::read_own;

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
        return match bag_inside(path)? {
            Some(bag) => read_mapped(&bag, map),
            None => read_folder(path),
        };
    }
    if map.is_some() {
        return read_foreign(path, map);
    }
    let (source, size) = bag::open(path)?;
    match read_own(source, size, path)? {
        Some(import) => Ok(import),
        None => read_foreign(path, None),
    }
}

/// The one MCAP file of a folder without `recording.toml`, as ROS 2 leaves it beside its
/// `metadata.yaml`.
fn bag_inside(folder: &Path) -> std::result::Result<Option<PathBuf>, Unusable> {
    if folder.join("recording.toml").exists() {
        return Ok(None);
    }
    let unreadable = |e| Unusable::unreadable(folder, &e);
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
            let problem = "holds neither recording.toml nor an MCAP file";
            let remedy = "give a folder of CSV files with recording.toml, or an MCAP file";
            Err(Unusable::new(folder, problem, remedy))
        }
        many => {
            let problem = format!("holds {many} MCAP files");
            Err(Unusable::new(folder, problem, "name one of them"))
        }
    }
}
