//! The table of one stream in a map of columns.

use std::path::{Component, Path};

use slipstream_bus::InputError;

use super::entry::{Column, ColumnEntry, FileFormat, Source, StreamEntry, TimeEntry};
use crate::table::{ColumnSet, StreamKind};
use crate::toml_files::{Entry, Section};

/// Keys of a stream besides its columns.
const STREAM_KEYS: [&str; 7] = [
    "file",
    "separator",
    "header",
    "t_s",
    "t_ns",
    "period_s",
    "times",
];
/// Keys of a pose for a yaw from a quaternion.
const QUATERNION: [&str; 4] = ["qx", "qy", "qz", "qw"];
/// Keys of a pose for a yaw from a direction.
const DIRECTION: [&str; 2] = ["forward_x", "forward_y"];

type ParsedStream<T> = Result<T, InputError>;

/// Reads the table of a stream.
///
/// # Errors
/// If it violates the format, with file and line.
pub(super) fn parse_stream(
    robot: &str,
    kind: StreamKind,
    entry: &Entry<'_>,
) -> ParsedStream<StreamEntry> {
    let section = entry.section()?;
    let own = kind.column_sets().iter().flat_map(|set| set.names());
    let mut keys: Vec<&str> = own.collect();
    keys.extend(STREAM_KEYS);
    if kind == StreamKind::Pose {
        keys.extend(QUATERNION);
        keys.extend(DIRECTION);
    }
    section.allow_only(&keys)?;
    let format = FileFormat {
        separator: separator(&section)?,
        has_header: section.get("header").map(|own| own.boolean()).transpose()?,
    };
    let column = FileColumns {
        has_header: format.has_header,
    };
    let mut columns = Vec::new();
    for (name, own) in section.entries() {
        if let Some(name) = kind.column(name) {
            columns.push((name, Source::One(column.parse(&own)?)));
        }
    }
    if kind == StreamKind::Pose
        && let Some(source) = column.turned(&section)?
    {
        if let Some(yaw) = section.get("yaw_rad") {
            return Err(yaw.error("is one of two sources of the yaw", "keep one of them"));
        }
        columns.push(("yaw_rad", source));
    }
    let present: Vec<&'static str> = columns.iter().map(|(name, _)| *name).collect();
    let set = ColumnSet::choose(kind, &present)
        .map_err(|(problem, remedy)| entry.error(problem, remedy))?;
    let order = |name: &&str| set.names().position(|known| known == *name);
    columns.sort_by_key(|(name, _)| order(name));
    Ok(StreamEntry {
        robot: robot.to_owned(),
        kind,
        file: section
            .get("file")
            .map(|file| file_name(&file))
            .transpose()?,
        format,
        time: column.time(&section)?,
        columns,
    })
}

/// A file in the folder of the recording.
fn file_name(file: &Entry<'_>) -> ParsedStream<String> {
    let name = file.text()?;
    let mut parts = Path::new(name).components();
    if !parts.all(|part| matches!(part, Component::Normal(_))) {
        let remedy = "name a file in the folder of the recording";
        return Err(file.error("leads out of the folder", remedy));
    }
    Ok(name.to_owned())
}

fn separator(section: &Section<'_>) -> ParsedStream<Option<u8>> {
    let Some(separator) = section.get("separator") else {
        return Ok(None);
    };
    match separator.text()?.as_bytes() {
        [byte] => Ok(Some(*byte)),
        _ => {
            let remedy = "write \",\", \";\", \"\\t\" or \" \" for runs of blanks";
            Err(separator.error("is not one character", remedy))
        }
    }
}

/// Reads columns of a file.
struct FileColumns {
    has_header: Option<bool>,
}

impl FileColumns {
    /// The time of a row: `t_s`, with `t_ns` if nanoseconds have a column of their own, `period_s`, or a file of `times`.
    fn time(&self, section: &Section<'_>) -> ParsedStream<TimeEntry> {
        let ns = section.get("t_ns");
        if let Some(entry) = section.get("times") {
            let others = ["t_s", "t_ns", "period_s"];
            return match others.iter().find_map(|key| section.get(key)) {
                None => Ok(TimeEntry::File(file_name(&entry)?)),
                Some(other) => Err(other.error("stands beside times", "keep one of them")),
            };
        }
        if let Some(entry) = section.get("period_s") {
            let period_s = entry.number()?;
            if period_s <= 0.0 {
                return Err(entry.error("is not above 0", "give the time from row to row (s)"));
            }
            return match section.get("t_s").or(ns) {
                None => Ok(TimeEntry::Period(period_s)),
                Some(other) => Err(other.error("stands beside period_s", "keep one of them")),
            };
        }
        let s = self.parse(&section.require("t_s")?)?;
        let Some(ns) = ns else {
            return Ok(TimeEntry::Column(s));
        };
        let both = [s, self.parse(&ns)?];
        if both
            .iter()
            .any(|own| own.factor != 1.0 || own.offset != 0.0)
        {
            let remedy =
                "give whole seconds in t_s and nanoseconds in t_ns, both without factor and offset";
            return Err(ns.error("is converted", remedy));
        }
        Ok(TimeEntry::Parts(both))
    }

    /// The yaw of a pose that does not say it itself.
    fn turned(&self, section: &Section<'_>) -> ParsedStream<Option<Source<ColumnEntry>>> {
        let get = |key| section.get(key).map(|own| self.parse(&own)).transpose();
        let is_given = |keys: &[&str]| keys.iter().any(|key| section.get(key).is_some());
        let require = |key| self.parse(&section.require(key)?);
        let [x, y, z, w] = QUATERNION;
        let [forward_x, forward_y] = DIRECTION;
        match (is_given(&QUATERNION), is_given(&DIRECTION)) {
            (false, false) => Ok(None),
            (true, false) => Ok(Some(Source::Quaternion(
                [get(x)?, get(y)?],
                [require(z)?, require(w)?],
            ))),
            (false, true) => Ok(Some(Source::Direction([
                require(forward_x)?,
                require(forward_y)?,
            ]))),
            (true, true) => {
                let problem = "has both a quaternion and a direction";
                Err(section.error(problem, "keep one of them"))
            }
        }
    }

    /// A name, a number, or a table with one of them and factor or offset.
    fn parse(&self, entry: &Entry<'_>) -> ParsedStream<ColumnEntry> {
        let mut factor = 1.0;
        let mut offset = 0.0;
        let column = if entry.value.is_table() {
            let section = entry.section()?;
            section.allow_only(&["column", "factor", "offset"])?;
            factor = section.number("factor")?.unwrap_or(factor);
            offset = section.number("offset")?.unwrap_or(offset);
            self.name(&section.require("column")?)?
        } else {
            self.name(entry)?
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

    fn name(&self, entry: &Entry<'_>) -> ParsedStream<Column> {
        if let Ok(name) = entry.text() {
            return match self.has_header {
                Some(false) => {
                    Err(entry.error("is a name, but the file has no header", "give its number"))
                }
                _ => Ok(Column::Name(name.to_owned())),
            };
        }
        let number = entry.number()?;
        if number.fract() != 0.0 || !(1.0..1e6).contains(&number) {
            return Err(entry.error("is not a column", "give a name, or a number from 1 on"));
        }
        Ok(Column::Number(number as usize))
    }
}
