//! Column map: which column of which CSV file is which column of which stream, as a small TOML file.
//!
//! ```toml
//! format = 1
//! [robots.r1.wheels]
//! file = "log.csv"                # in the recording's folder; not needed if the recording is one file
//! t_s = { column = "time_ms", factor = 0.001 }
//! angle_right_rad = "right"       # the name of the column
//! angle_left_rad = "left"
//! [robots.r1.pose]
//! file = "camera.txt"
//! separator = ";"                 # a comma, where it is not said
//! header = false                  # then columns are numbers, from 1 on
//! t_s = 1
//! x_m = 2
//! y_m = 3
//! yaw_rad = { column = 4, factor = 0.017453292519943295, offset = -1.5707963267948966 }
//! ```
//!
//! A cell becomes `cell * factor + offset`. Rows in which all columns of a stream are empty do not belong to it, so that
//! one file may hold several streams.

use std::path::{Component, Path};

use slipstream_bus::InputError;

use crate::error::Result;
use crate::recording::{PosePoint, Robot, is_robot_name};
use crate::table::{ColumnSet, StreamKind};
use crate::toml_files::{Entry, Section, TomlFile, read_text};

/// Which column of which file is which column of which stream.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ColumnMap {
    /// The robots, without streams.
    pub(super) robots: Vec<RobotEntry>,
    /// The streams.
    pub(super) streams: Vec<StreamEntry>,
}

/// What is said of a robot.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RobotEntry {
    name: String,
    is_pose_of_mass: bool,
    encoder_counts_per_rev: Option<f64>,
}

/// A stream and the file that holds it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StreamEntry {
    pub(super) robot: String,
    pub(super) kind: StreamKind,
    /// Name of the file; `None` if the recording is the file.
    pub(super) file: Option<String>,
    pub(super) separator: u8,
    pub(super) has_header: bool,
    pub(super) time: ColumnEntry,
    /// Columns of the format with their sources, in the order of the format.
    pub(super) columns: Vec<(&'static str, ColumnEntry)>,
}

/// A column of a file and how to convert its cells.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ColumnEntry {
    pub(super) column: Column,
    pub(super) factor: f64,
    pub(super) offset: f64,
}

/// A column of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Column {
    /// Name in the header.
    Name(String),
    /// Number, from 1 on.
    Number(usize),
}

/// Keys of a stream besides its columns.
const STREAM_KEYS: [&str; 4] = ["file", "separator", "header", "t_s"];
/// Keys of a robot besides its streams.
const ROBOT_KEYS: [&str; 2] = ["pose_point", "encoder_counts_per_rev"];

type Parsed<T> = std::result::Result<T, InputError>;

impl ColumnMap {
    /// Reads a map from a file.
    ///
    /// # Errors
    /// If the file cannot be read or violates the format, with file and line.
    pub fn read(path: &Path) -> Result<Self> {
        Ok(Self::parse(&read_text(path)?, path)?)
    }

    /// Parses the text of a map. `path` is used in errors only.
    ///
    /// # Errors
    /// As [`ColumnMap::read`].
    pub fn parse(text: &str, path: &Path) -> Parsed<Self> {
        let file = TomlFile { path, text };
        let table = file.parse()?;
        let root = file.root(&table);
        root.require_format_1()?;
        root.allow_only(&["format", "robots"])?;
        let robots = root.require("robots")?;
        let mut map = Self::default();
        for (name, entry) in robots.section()?.entries() {
            if !is_robot_name(name) {
                let remedy = "use letters, digits, `_` and `-`";
                return Err(entry.error("is not a valid robot name", remedy));
            }
            map.add_robot(name, &entry.section()?)?;
        }
        if map.streams.is_empty() {
            let remedy = "add a table such as [robots.r1.pose]";
            return Err(robots.error("maps no stream", remedy));
        }
        Ok(map)
    }

    fn add_robot(&mut self, name: &str, section: &Section<'_>) -> Parsed<()> {
        let mut keys = StreamKind::ALL.map(StreamKind::name).to_vec();
        keys.extend(ROBOT_KEYS);
        section.allow_only(&keys)?;
        self.robots.push(RobotEntry {
            name: name.to_owned(),
            is_pose_of_mass: section.is_pose_of_mass()?,
            encoder_counts_per_rev: section
                .get("encoder_counts_per_rev")
                .map(|counts| counts.counts_per_rev())
                .transpose()?,
        });
        for kind in StreamKind::ALL {
            if let Some(stream) = section.get(kind.name()) {
                self.streams.push(parse_stream(name, kind, &stream)?);
            }
        }
        Ok(())
    }

    /// The robots, without streams.
    pub(super) fn robots(&self) -> Vec<Robot> {
        let robot = |entry: &RobotEntry| Robot {
            encoder_counts_per_rev: entry.encoder_counts_per_rev,
            pose_point: Some(if entry.is_pose_of_mass {
                PosePoint::CentreOfMass
            } else {
                PosePoint::Axle
            }),
            ..Robot::named(&entry.name)
        };
        self.robots.iter().map(robot).collect()
    }
}

fn parse_stream(robot: &str, kind: StreamKind, entry: &Entry<'_>) -> Parsed<StreamEntry> {
    let section = entry.section()?;
    let own = kind.column_sets().iter().flat_map(|set| set.names());
    let mut keys: Vec<&str> = own.collect();
    keys.extend(STREAM_KEYS);
    section.allow_only(&keys)?;
    let has_header = match section.get("header") {
        None => true,
        Some(header) => header.boolean()?,
    };
    let mut columns = Vec::new();
    for (name, column) in section.entries() {
        if let Some(name) = kind.column(name) {
            columns.push((name, parse_column(&column, has_header)?));
        }
    }
    let present: Vec<&'static str> = columns.iter().map(|(name, _)| *name).collect();
    let set = ColumnSet::choose(kind, &present)
        .map_err(|(problem, remedy)| entry.error(problem, remedy))?;
    let order = |name: &&str| set.names().position(|known| known == *name);
    columns.sort_by_key(|(name, _)| order(name));
    Ok(StreamEntry {
        robot: robot.to_owned(),
        kind,
        file: match section.get("file") {
            None => None,
            Some(file) => {
                let name = file.text()?;
                let mut parts = Path::new(name).components();
                if !parts.all(|part| matches!(part, Component::Normal(_))) {
                    let remedy = "name a file in the folder of the recording";
                    return Err(file.error("leads out of the folder", remedy));
                }
                Some(name.to_owned())
            }
        },
        separator: match section.get("separator") {
            None => b',',
            Some(separator) => match separator.text()?.as_bytes() {
                [byte] => *byte,
                _ => {
                    return Err(
                        separator.error("is not one character", "write \",\", \";\" or \"\\t\"")
                    );
                }
            },
        },
        has_header,
        time: parse_column(&section.require("t_s")?, has_header)?,
        columns,
    })
}

/// A name, a number, or a table with one of them and factor or offset.
fn parse_column(entry: &Entry<'_>, has_header: bool) -> Parsed<ColumnEntry> {
    let mut factor = 1.0;
    let mut offset = 0.0;
    let column = if entry.value.is_table() {
        let section = entry.section()?;
        section.allow_only(&["column", "factor", "offset"])?;
        factor = section.number("factor")?.unwrap_or(factor);
        offset = section.number("offset")?.unwrap_or(offset);
        parse_name(&section.require("column")?, has_header)?
    } else {
        parse_name(entry, has_header)?
    };
    if factor == 0.0 {
        return Err(entry.error(
            "has the factor 0",
            "give the factor from the file's unit to SI",
        ));
    }
    Ok(ColumnEntry {
        column,
        factor,
        offset,
    })
}

fn parse_name(entry: &Entry<'_>, has_header: bool) -> Parsed<Column> {
    if let Ok(name) = entry.text() {
        return match has_header {
            true => Ok(Column::Name(name.to_owned())),
            false => Err(entry.error("is a name, but the file has no header", "give its number")),
        };
    }
    let number = entry.number()?;
    if number.fract() != 0.0 || !(1.0..1e6).contains(&number) {
        return Err(entry.error("is not a column", "give a name, or a number from 1 on"));
    }
    Ok(Column::Number(number as usize))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        let text = format!("format = 1\n[robots.r1.pose]\n{text}");
        let map = ColumnMap::parse(&text, Path::new("map.toml"));
        map.unwrap_err().to_string()
    }

    #[test]
    fn errors_name_line_key_and_remedy() {
        let cases = [
            ("x_m = 1\ny_m = 2", "robots.r1.pose.t_s is missing"),
            ("t_s = \"t\"\nx_m = \"x\"", "y_m"),
            (
                "t_s = \"t\"\nx = 1",
                "map.toml:4: robots.r1.pose.x is not a key",
            ),
            (
                "header = false\nt_s = \"t\"\nx_m = 1\ny_m = 2",
                "but the file has no header",
            ),
            ("t_s = 0\nx_m = 1\ny_m = 2", "is not a column"),
            (
                "t_s = { column = 1, factor = 0 }\nx_m = 1\ny_m = 2",
                "has the factor 0",
            ),
            (
                "file = \"../x.csv\"\nt_s = 1\nx_m = 1\ny_m = 2",
                "leads out of the folder",
            ),
            (
                "separator = \";;\"\nt_s = 1\nx_m = 1\ny_m = 2",
                "is not one character",
            ),
        ];
        for (text, expected) in cases {
            let error = error(text);
            assert!(error.contains(expected), "{error}");
        }
    }
}
