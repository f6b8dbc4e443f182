//! The map of columns that files seem to have: to be read with, and to be completed by a person.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use slipstream_bag::Result;
use slipstream_bus::InputError;

use super::column_map::ColumnMap;
use super::entry::{Column, FileFormat, RobotEntry, Source, StreamEntry, TimeEntry};
use super::guess::{Guessed, guess};
use super::layout::{Layout, Sample};
use super::map_text::table_text;
use crate::table::StreamKind;

/// Name of a robot that the file does not name.
const ROBOT: &str = "robot";
/// So many cells of a row without names are shown.
const SHOWN_CELLS: usize = 100;

/// The guess of a map.
#[derive(Debug)]
pub(crate) struct Draft {
    /// What was guessed; no stream, if nothing was.
    pub(crate) map: ColumnMap,
    files: Vec<DraftFile>,
}

/// A file and its part of the guess.
#[derive(Debug)]
struct DraftFile {
    name: String,
    sample: Sample,
    /// The streams, each with what a person should know about it.
    streams: Vec<(StreamEntry, Option<&'static str>)>,
    /// Streams that another file has already.
    left_out: Vec<StreamKind>,
}

impl Draft {
    /// Guesses the map of the files in a folder, or of one file.
    ///
    /// # Errors
    /// If there is no CSV file, or one cannot be read.
    pub(crate) fn of(path: &Path) -> Result<Self> {
        let mut files = Vec::new();
        let mut known = Vec::new();
        for at in csv_files(path)? {
            if is_times(&at) {
                continue;
            }
            let sample = Sample::read(&at, FileFormat::default())?;
            let name = at.file_name().unwrap_or_default().to_string_lossy();
            let all = guess(&sample, &name).into_iter();
            let key = |own: &Guessed| (own.robot.clone(), own.kind);
            let (old, new): (Vec<_>, Vec<_>) = all.partition(|own| known.contains(&key(own)));
            known.extend(new.iter().map(key));
            let format = format_of(&sample.layout);
            // The map of one file serves others of its kind.
            let file = path.is_dir().then(|| name.clone().into_owned());
            let streams = new
                .into_iter()
                .map(|own| stream(with_times(own, &at), file.clone(), format));
            files.push(DraftFile {
                name: name.clone().into_owned(),
                streams: streams.collect(),
                left_out: old.into_iter().map(|own| own.kind).collect(),
                sample,
            });
        }
        let streams = files.iter().flat_map(|file| &file.streams);
        let streams: Vec<StreamEntry> = streams.map(|(stream, _)| stream.clone()).collect();
        let mut robots: Vec<RobotEntry> = Vec::new();
        for stream in &streams {
            if robots.iter().all(|known| known.name != stream.robot) {
                robots.push(RobotEntry {
                    name: stream.robot.clone(),
                    is_pose_of_mass: false,
                    encoder_counts_per_rev: None,
                });
            }
        }
        let map = ColumnMap { robots, streams };
        Ok(Self { map, files })
    }

    /// The tables of the streams, as they stand in a map.
    pub(crate) fn tables(&self) -> String {
        let tables = self.map.streams.iter().map(table_text);
        format!("format = 1\n{}", tables.collect::<String>())
    }

    /// What a person should know about the guess, one entry each.
    pub(crate) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for file in &self.files {
            let name = &file.name;
            for (stream, note) in &file.streams {
                let note = note.map(|note| format!("{name}: {}: {note}", stream.kind.name()));
                notes.extend(note);
            }
            let left_out = file.left_out.iter().map(|kind| kind.name());
            notes.extend(
                left_out.map(|kind| format!("{name}: {kind}: left out, since another file has it")),
            );
            let unused = file.unused();
            if file.streams.is_empty() && file.left_out.is_empty() {
                notes.push(format!(
                    "{name}: not used, since its columns do not tell what they are"
                ));
            } else if !unused.is_empty() {
                notes.push(format!("{name}: columns not used: {}", unused.join(", ")));
            }
        }
        notes
    }

    /// The whole text of a map, with the columns of all files and the streams that are missing.
    pub(crate) fn text(&self) -> String {
        let mut text = String::from(
            "# Which column is what, as guessed from names and first rows. Correct it, then give it with --columns.\n\
             # A cell becomes cell * factor + offset: write { column = \"heading_deg\", factor = 0.017453292519943295 } for\n\
             # degrees, factor = 0.001 for milliseconds or mm.\n\
             format = 1\n",
        );
        for file in &self.files {
            // Writing to a string cannot fail.
            let columns = file.columns().replace(|c: char| c.is_control(), " ");
            let _ = writeln!(text, "\n# {columns}");
            for (stream, note) in &file.streams {
                if let Some(note) = note {
                    let _ = writeln!(text, "# {note}");
                }
                text.push_str(&table_text(stream));
            }
            for kind in &file.left_out {
                let _ = writeln!(
                    text,
                    "# {}: left out, since another file has it",
                    kind.name()
                );
            }
        }
        let is_known = |kind: &StreamKind| self.map.streams.iter().any(|own| own.kind == *kind);
        for kind in StreamKind::ALL.into_iter().filter(|kind| !is_known(kind)) {
            let sets = kind.column_sets().iter();
            let sets = sets.map(|set| set.names().collect::<Vec<_>>().join(", "));
            let sets: Vec<String> = sets.collect();
            let (kind, sets) = (kind.name(), sets.join("; or "));
            let _ = writeln!(text, "\n# [robots.{ROBOT}.{kind}]: t_s and {sets}");
        }
        text
    }
}

impl DraftFile {
    /// The columns of the file, for a person.
    fn columns(&self) -> String {
        let name = &self.name;
        let layout = &self.sample.layout;
        if !layout.names.is_empty() {
            return format!("{name} has the columns: {}", layout.names.join(", "));
        }
        let first = self.sample.rows.first().map_or(&[][..], Vec::as_slice);
        let cells = first.iter().take(SHOWN_CELLS).enumerate();
        let cells = cells.map(|(index, cell)| format!("{} = {cell}", index + 1));
        let cells: Vec<String> = cells.collect();
        format!("{name} has no header; its first row: {}", cells.join(", "))
    }

    /// Columns with names that no stream uses; a list of numbered ones as its first and last.
    fn unused(&self) -> Vec<String> {
        let uses = |name: &String| {
            let is_it = |column: &Column| matches!(column, Column::Name(own) if own == name);
            self.streams
                .iter()
                .any(|(stream, _)| columns_of(stream).into_iter().any(is_it))
        };
        let names = self.sample.layout.names.iter();
        let names: Vec<&String> = names
            .filter(|name| !name.is_empty() && !uses(name))
            .collect();
        let stem = |name: &str| {
            let stem = name.trim_end_matches(|c: char| !c.is_ascii_alphabetic());
            stem.to_owned()
        };
        let lists = names.chunk_by(|a, b| stem(a) == stem(b) && stem(a) != **a);
        let lists = lists.filter_map(|list| match list {
            [only] => Some((*only).clone()),
            [first, .., last] => Some(format!("{first} to {last}")),
            [] => None,
        });
        lists.collect()
    }
}

/// The columns that a stream reads.
fn columns_of(stream: &StreamEntry) -> Vec<&Column> {
    let mut columns = match &stream.time {
        TimeEntry::Column(column) => vec![column],
        TimeEntry::Parts([s, ns]) => vec![s, ns],
        TimeEntry::Period(_) | TimeEntry::File(_) => Vec::new(),
    };
    for (_, source) in &stream.columns {
        match source {
            Source::One(column) => columns.push(column),
            Source::Direction(both) => columns.extend(both),
            Source::Quaternion(first, last) => {
                columns.extend(first.iter().flatten());
                columns.extend(last);
            }
        }
    }
    columns.into_iter().map(|entry| &entry.column).collect()
}

/// Name of a file with the times of the rows of others.
const TIMES: &str = "times.txt";

/// Whether a file has the times of others beside it.
fn is_times(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name == TIMES)
}

/// A stream without times, with those that stand beside its file.
fn with_times(mut guessed: Guessed, file: &Path) -> Guessed {
    let has_none = matches!(guessed.time, TimeEntry::Period(_));
    if has_none && file.with_file_name(TIMES).is_file() {
        guessed.time = TimeEntry::File(TIMES.to_owned());
        guessed.note = None;
    }
    guessed
}

fn stream(
    guessed: Guessed,
    file: Option<String>,
    format: FileFormat,
) -> (StreamEntry, Option<&'static str>) {
    let Guessed {
        robot,
        kind,
        time,
        columns,
        note,
    } = guessed;
    let stream = StreamEntry {
        robot: robot.unwrap_or_else(|| ROBOT.to_owned()),
        kind,
        file,
        format,
        time,
        columns,
    };
    (stream, note)
}

/// What a map should say of a file's layout: what is not usual.
fn format_of(layout: &Layout) -> FileFormat {
    FileFormat {
        separator: Some(layout.separator).filter(|separator| *separator != b','),
        has_header: layout.names.is_empty().then_some(false),
    }
}

/// The CSV files of a folder, sorted by name; or the file itself.
pub(crate) fn csv_files(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let unreadable = |e| InputError::unreadable(path, &e);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(unreadable)? {
        let file = entry.map_err(unreadable)?.path();
        let endings = ["csv", "txt", "tsv", "dat", "tum", "log"];
        if file
            .extension()
            .is_some_and(|own| endings.iter().any(|ending| own == *ending))
        {
            files.push(file);
        }
    }
    if files.is_empty() {
        return Err(
            InputError::file(path, "contains no CSV file", "give a folder with CSV files").into(),
        );
    }
    files.sort();
    Ok(files)
}
