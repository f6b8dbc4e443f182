//! Reads a recording of any supported form.

use std::path::{Path, PathBuf};

use slipstream_bag::{Bag, BagBytes, BagFile, BagFolder, Container, Error, Result, is_bag};
use slipstream_bus::InputError;

use crate::carried::{description_in, draft_with_model, read_with_model};
use crate::csv_folder::spool_folder;
use crate::foreign_bag::{TopicMap, WheelJoints};
use crate::foreign_csv::{ColumnMap, Draft, is_text, read_columns};
use crate::import::{Import, Spooled};
use crate::mcap_file::{is_own, read_own};
use crate::robot_file::{self, Described};
use crate::sysid_json::{is_json, read_sysid};

/// What a user says about recordings that other programs wrote.
#[derive(Debug, Clone, Default)]
pub enum Map {
    /// Nothing: topics of a bag and columns of text files are guessed.
    #[default]
    None,
    /// Which topic of a bag is which stream.
    Topics(TopicMap),
    /// Which column of text files is which column of a stream.
    Columns(ColumnMap),
}

impl Map {
    /// Reads a map of topics or of columns; nothing, if neither file is given.
    ///
    /// # Errors
    /// If the file cannot be read or violates its format.
    pub fn read(topics: Option<&Path>, columns: Option<&Path>) -> Result<Self> {
        Ok(match (topics, columns) {
            (Some(file), _) => Self::Topics(TopicMap::read(file)?),
            (_, Some(file)) => Self::Columns(ColumnMap::read(file)?),
            (None, None) => Self::None,
        })
    }
}

/// What a path is.
enum PathForm {
    /// A folder of CSV files with `recording.toml`.
    Folder,
    /// A bag in one file.
    Bag(BagFile),
    /// A bag in a folder.
    Bags(BagFolder),
    /// A text file of others, or a folder of CSV files.
    Csv,
    /// A log of SysId.
    SysId,
}

impl PathForm {
    fn of(path: &Path) -> Result<Self> {
        let metadata = std::fs::metadata(path).map_err(|e| InputError::unreadable(path, &e))?;
        if !metadata.is_dir() {
            // Pointers of Git LFS, which are text, are refused here.
            let bag = BagFile::open(path)?;
            let is_text = !is_bag(path)? && is_text(path)?;
            return Ok(match is_text {
                true if is_json(path)? => Self::SysId,
                true => Self::Csv,
                false => Self::Bag(bag),
            });
        }
        if path.join("recording.toml").exists() {
            return Ok(Self::Folder);
        }
        Ok(match BagFolder::open(path)? {
            None => Self::Csv,
            Some(folder) => match folder.into_only_part() {
                Ok(part) => Self::Bag(part),
                Err(folder) => Self::Bags(folder),
            },
        })
    }
}

/// Reads a recording: a folder of CSV files; an MCAP file that slipstream wrote; a bag of another robot, which may be
/// an MCAP file, an SQLite database or a folder of them, as ROS 2 writes it, a ROS 1 bag or a WPILib data log; or text
/// files of others. The topics of a foreign bag and the columns of text files are guessed ([`Import::guesses`]).
///
/// # Errors
/// If it is none of these, cannot be read, or violates its format.
pub fn read(path: &Path) -> Result<Import> {
    read_mapped(path, &Map::None)
}

/// As [`read`]. With topics, a bag is read as one of another robot; with columns, text files are read as they say.
///
/// # Errors
/// As [`read`], or if a topic or column of the map does not exist or cannot provide its stream.
pub fn read_mapped(path: &Path, map: &Map) -> Result<Import> {
    read_spooled(path, map, &[])?.load()
}

/// As [`read_mapped`], for recordings of any length: the rows stay in a temporary file. `wheels` are the joints of driven wheels
/// that descriptions of the robots name ([`Described::wheel_joints`]); they tell a guess the sides.
///
/// # Errors
/// As [`read_mapped`], or if the temporary file cannot be written.
pub fn read_spooled(path: &Path, map: &Map, wheels: &[WheelJoints]) -> Result<Spooled> {
    let topics = match map {
        Map::Topics(topics) => Some(topics),
        _ => None,
    };
    let form = PathForm::of(path)?;
    let unused = match (&form, map) {
        (PathForm::Folder | PathForm::Csv | PathForm::SysId, Map::Topics(_)) => {
            Some("has no topics")
        }
        (PathForm::Folder, Map::Columns(_)) => {
            Some("has recording.toml, which says what the columns are")
        }
        (PathForm::SysId, Map::Columns(_)) => Some("is a log of SysId, whose columns are known"),
        (PathForm::Bag(_) | PathForm::Bags(_), Map::Columns(_)) => {
            Some("is a bag, which has no columns")
        }
        _ => None,
    };
    let mut spooled = match form {
        PathForm::Folder => spool_folder(path)?,
        PathForm::Csv => match map {
            Map::Columns(columns) => read_columns(path, columns)?,
            _ => read_guessed(path)?,
        },
        PathForm::SysId => read_sysid(path)?,
        PathForm::Bag(bag) => read_file(&bag, topics, wheels)?,
        PathForm::Bags(bags) => read_with_model(&bags, path, topics, wheels)?,
    };
    if let Some(reason) = unused {
        let path = path.display();
        spooled
            .warnings
            .push(format!("{path} {reason}: the map is not used for it"));
    }
    Ok(spooled)
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
    read_with_model(&bag, path, map, &[])?.load()
}

/// The text of a map for a recording that another program wrote, to be completed by a person: of topics for a bag, of
/// columns for CSV files. `wheels` as in [`read_spooled`].
///
/// # Errors
/// If the recording cannot be read, or needs no map.
pub fn draft_map(path: &Path, wheels: &[WheelJoints]) -> Result<String> {
    match PathForm::of(path)? {
        PathForm::Csv => Ok(Draft::of(path)?.text()),
        PathForm::Bag(bag) => draft_with_model(&bag, path, wheels),
        PathForm::Bags(bags) => draft_with_model(&bags, path, wheels),
        PathForm::Folder | PathForm::SysId => {
            let problem = "says what its columns are, and needs no map";
            Err(InputError::file(path, problem, "give it without a map").into())
        }
    }
}

/// Reads the description of a robot, from one file or from several that fill what the others lack: robot.toml, URDF, the
/// YAML of a controller, constants of a program, or a bag with a topic `robot_description`.
///
/// # Errors
/// As [`robot_file::parse_all`], or if a bag has no description.
pub fn describe_robot(paths: &[&Path]) -> Result<Described> {
    let files: Result<Vec<(PathBuf, String)>> =
        paths.iter().map(|path| description(path)).collect();
    let files = files?;
    let files: Vec<(&Path, &str)> = files
        .iter()
        .map(|(path, text)| (&**path, &**text))
        .collect();
    Ok(robot_file::parse_all(&files)?)
}

/// Reads the descriptions of robots: for each name, and for all robots (`None`), from the files that are given for it.
///
/// # Errors
/// As [`describe_robot`].
pub fn describe_robots(
    files: &[(Option<String>, PathBuf)],
) -> Result<Vec<(Option<String>, Described)>> {
    let mut names: Vec<&Option<String>> = Vec::new();
    for (name, _) in files {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let describe = |name: &Option<String>| {
        let own = files.iter().filter(|(other, _)| other == name);
        let own: Vec<&Path> = own.map(|(_, path)| path.as_path()).collect();
        Ok((name.clone(), describe_robot(&own)?))
    };
    names.into_iter().map(describe).collect()
}

/// The text that describes a robot, and its place.
fn description(path: &Path) -> Result<(PathBuf, String)> {
    if !path.is_dir() && !is_bag(path)? {
        return Ok((path.to_owned(), slipstream_bag::read_text(path)?));
    }
    match PathForm::of(path)? {
        PathForm::Bag(bag) => description_in(&bag, path),
        PathForm::Bags(bags) => description_in(&bags, path),
        PathForm::Folder | PathForm::Csv | PathForm::SysId => {
            let problem = "is a folder without a bag";
            let remedy = "give a URDF, the YAML of a controller or a robot.toml";
            Err(InputError::file(path, problem, remedy).into())
        }
    }
}

/// Reads a file: one of our own, or a bag of another robot.
fn read_file(bag: &BagFile, topics: Option<&TopicMap>, wheels: &[WheelJoints]) -> Result<Spooled> {
    let may_be_own = bag.container == Container::Mcap && topics.is_none();
    // A file without an index is read as one of our own first.
    if may_be_own && bag.summary().is_none_or(|summary| is_own(&summary)) {
        let (source, size) = bag.source()?;
        if let Some(import) = read_own(source, size, bag.path())? {
            return Ok(import);
        }
    }
    read_with_model(bag as &dyn Bag, bag.path(), topics, wheels)
}

/// Reads text files with the map that they seem to have.
fn read_guessed(path: &Path) -> Result<Spooled> {
    if csv_in(path).is_none() {
        return Err(not_mapped(path));
    }
    let draft = Draft::of(path)?;
    if draft.map.is_empty() {
        return Err(not_mapped(path));
    }
    let mut spooled = read_columns(path, &draft.map).map_err(|error| match error {
        Error::Input(error) => InputError {
            remedy: format!("{}; the columns were guessed: {CORRECTION}", error.remedy),
            ..error
        }
        .into(),
        error => error,
    })?;
    let tables = draft.tables();
    let shown = path.display();
    spooled.guesses = vec![format!(
        "{shown}: guessed columns:\n{tables}# To correct it: {CORRECTION}"
    )];
    spooled.guesses.extend(draft.notes());
    Ok(spooled)
}

/// What to do where columns are not known, or guessed wrongly.
const CORRECTION: &str = "`slipstream check RECORDING --write-columns FILE.toml` writes a map to be corrected; then give --columns FILE.toml";

/// Text files whose columns are not known need a map; a folder may have none.
fn not_mapped(path: &Path) -> Error {
    let error = match csv_in(path) {
        Some(file) => {
            let name = file.display();
            let of_which = if file == path {
                "its columns".to_owned()
            } else {
                format!("the columns of {name}")
            };
            let problem = format!("needs a map of {of_which}, which do not tell what they are");
            InputError::file(path, problem, CORRECTION)
        }
        None => {
            let problem = "contains neither recording.toml nor a bag";
            let remedy = "give a bag (MCAP, SQLite, ROS 1), or a folder of CSV files";
            InputError::file(path, problem, remedy)
        }
    };
    error.into()
}

/// A CSV file at or in a path.
fn csv_in(path: &Path) -> Option<PathBuf> {
    crate::foreign_csv::csv_files(path).ok()?.into_iter().next()
}
