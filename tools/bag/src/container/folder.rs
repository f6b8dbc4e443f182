//! A folder as rosbag2 writes it: `metadata.yaml` and one bag file, or several after each other.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

use super::item::{Visit, Wanted};
use super::loss::Loss;
use super::source::{Bag, BagFile};
use crate::text_file::read_text;
use crate::yaml::{self, Node, Value};

/// Name of the description in the folder.
const METADATA: &str = "metadata.yaml";

/// The bag files of a folder, in the order of recording.
#[derive(Debug)]
pub struct BagFolder {
    parts: Vec<BagFile>,
    /// Files of the description that are not in the folder.
    missing: Vec<String>,
}

impl BagFolder {
    /// Finds the bag files of a folder: those of its `metadata.yaml`, without one all of them. `None` if there is none.
    ///
    /// # Errors
    /// If the folder or a file cannot be read, or `metadata.yaml` is not a description of a bag.
    pub fn open(folder: &Path) -> Result<Option<Self>, InputError> {
        let files = bag_files(folder)?;
        let metadata = folder.join(METADATA);
        let mut missing = Vec::new();
        let mut paths = Vec::new();
        if !metadata.exists() && files.len() > 1 {
            missing.push(METADATA.to_owned());
        } else if metadata.exists() {
            for name in names_in(&metadata)? {
                match find(&files, &name) {
                    Some(path) => paths.push(path),
                    None => missing.push(name),
                }
            }
        }
        // A recorder that was killed writes no description.
        if paths.is_empty() {
            paths = files;
        }
        if paths.is_empty() {
            return Ok(None);
        }
        let parts: Result<_, _> = paths.iter().map(|path| BagFile::open(path)).collect();
        Ok(Some(Self {
            parts: parts?,
            missing,
        }))
    }

    /// The file, if the bag has only one and should have no other; else the folder.
    pub fn into_only_part(mut self) -> Result<BagFile, Self> {
        match self.parts.pop() {
            Some(part) if self.parts.is_empty() && self.missing.is_empty() => Ok(part),
            part => {
                self.parts.extend(part);
                Err(self)
            }
        }
    }
}

impl Bag for BagFolder {
    fn scan(&self, wanted: &Wanted<'_>, visit: &mut Visit<'_>) -> Result<Loss, InputError> {
        let mut loss = Loss {
            missing_files: self.missing.clone(),
            ..Loss::default()
        };
        for part in &self.parts {
            match part.scan(wanted, visit) {
                Ok(more) => loss.add(&more),
                // A part that cannot be read costs its messages, not those of the others.
                Err(error) if loss.unreadable_files.len() + 1 < self.parts.len() => {
                    loss.unreadable_files.push(error.to_string());
                }
                Err(error) => return Err(error),
            }
        }
        Ok(loss)
    }
}

/// The file names in a description. Early versions of rosbag2 wrote the folder before them.
fn names_in(metadata: &Path) -> Result<Vec<String>, InputError> {
    let documents = yaml::parse(&read_text(metadata)?, metadata)?;
    let information = documents
        .first()
        .and_then(|root| root.get("rosbag2_bagfile_information"));
    let files = information.and_then(|own| own.get("relative_file_paths"));
    let Some(Value::List(files)) = files.map(|files| &files.value) else {
        let problem = "has no rosbag2_bagfile_information.relative_file_paths";
        let remedy = "delete the file: the bag files of the folder are then read by their names";
        return Err(InputError::file(metadata, problem, remedy));
    };
    let name = |node: &Node| match &node.value {
        Value::Scalar { text, .. } => {
            let name = Path::new(text).file_name();
            name.map(|name| name.to_string_lossy().into_owned())
        }
        _ => None,
    };
    Ok(files.iter().filter_map(name).collect())
}

/// The MCAP files in a folder that are not compressed as a whole, by their numbers.
///
/// # Errors
/// If the folder cannot be read.
pub fn mcap_files(folder: &Path) -> Result<Vec<PathBuf>, InputError> {
    let mut files = bag_files(folder)?;
    files.retain(|path| path.extension().is_some_and(|own| own == "mcap"));
    Ok(files)
}

/// The bag files in a folder, by their numbers.
fn bag_files(folder: &Path) -> Result<Vec<PathBuf>, InputError> {
    let unreadable = |e| InputError::unreadable(folder, &e);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let name = path.file_name().map(|name| name.to_string_lossy());
        let name = name.unwrap_or_default();
        if stem(&name).is_some() {
            files.push(path);
        }
    }
    files.sort_by(|a, b| by_numbers(a, b));
    Ok(files)
}

/// The file of this name, or the compressed one.
fn find(files: &[PathBuf], name: &str) -> Option<PathBuf> {
    let compressed = format!("{name}.zstd");
    let is_it = |path: &&PathBuf| {
        let own = path.file_name();
        own.is_some_and(|own| own == name || *own == *compressed)
    };
    files.iter().find(is_it).cloned()
}

/// The name of a bag file without its endings; `None` for other files.
fn stem(name: &str) -> Option<&str> {
    let name = name.strip_suffix(".zstd").unwrap_or(name);
    let endings = [".mcap", ".db3", ".bag"].iter();
    endings
        .copied()
        .find_map(|ending| name.strip_suffix(ending))
}

/// `bag_2` comes before `bag_10`.
fn by_numbers(a: &Path, b: &Path) -> Ordering {
    let key = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let stem = stem(&name).unwrap_or(&name);
        let word = stem.trim_end_matches(|c: char| c.is_ascii_digit());
        let number: Option<u64> = stem[word.len()..].parse().ok();
        (word.to_owned(), number)
    };
    key(a).cmp(&key(b)).then_with(|| a.cmp(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_in_the_order_of_their_numbers() {
        let mut paths = ["bag_10.db3", "bag_2.db3", "bag_0.db3.zstd"].map(PathBuf::from);
        paths.sort_by(|a, b| by_numbers(a, b));
        assert_eq!(
            paths,
            ["bag_0.db3.zstd", "bag_2.db3", "bag_10.db3"].map(PathBuf::from)
        );
    }
}
