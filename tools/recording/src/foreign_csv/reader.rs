//! Reader of CSV files of others.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use slipstream_bag::Result;
use slipstream_bag::ros::messages::Quaternion;
use slipstream_bus::InputError;

use super::clock::{Clock, unit_of};
use super::column_map::ColumnMap;
use super::entry::{Source, StreamEntry};
use super::moment::Moment;
use super::table::{Cell, ForeignCsv};
use crate::import::Spooled;
use crate::recording::{ReadFrom, Recording};
use crate::rows::{Disk, Spool, SpooledRecording, sorted_by_time};
use crate::table::{Table, is_time, out_of_range};

/// Whole numbers of a smaller size are exact in floating point (2^53).
const MAX_EXACT_INTEGER: f64 = 9_007_199_254_740_992.0;

/// Reads a folder of CSV files, or one file, as the map says. Times count from the first row of all streams.
///
/// # Errors
/// If a file or column of the map does not exist, a cell is not a number, or a stream would be empty.
pub(crate) fn read_columns(path: &Path, map: &ColumnMap) -> Result<Spooled> {
    let mut starts = Vec::new();
    for stream in &map.streams {
        starts.push(start_of(&file_of(path, stream)?, stream)?);
    }
    let first = starts.iter().min_by(|a, b| a.t_s().total_cmp(&b.t_s()));
    let first = first.copied().unwrap_or_default();
    let name = path.file_stem().map(|stem| stem.to_string_lossy());
    let description = Recording {
        name: name.unwrap_or_default().into_owned(),
        origin: "CSV files, read with a map of their columns".to_owned(),
        read_from: ReadFrom::Columns,
        robots: map.robots(),
        ..Recording::default()
    };
    let disk = Disk::default();
    let mut recording = SpooledRecording::new(description, disk.clone());
    let mut warnings = Vec::new();
    for (stream, start) in map.streams.iter().zip(&starts) {
        let file = file_of(path, stream)?;
        let (spool, left_out) = read_stream(&file, stream, [*start, first], &disk)?;
        let shown = file.display();
        for what in left_out {
            let warning = format!("{shown}: {what}; left out");
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
        if !spool.is_sorted() {
            warnings.push(format!("{shown}: times run backwards; sorted by time"));
        }
        recording.store(&stream.robot, stream.kind, sorted_by_time(spool));
    }
    warnings.extend(apart(map, &starts));
    recording.disk.check()?;
    Ok(Spooled {
        recording,
        guesses: Vec::new(),
        warnings,
        on_model: Vec::new(),
        loss: None,
        left_out: BTreeMap::new(),
    })
}

/// No two files of a recording begin so long after each other (s): three years.
const MOST_APART_S: f64 = 1e8;

/// What to say of files whose times count from different origins.
fn apart(map: &ColumnMap, starts: &[FirstMoment]) -> Option<String> {
    let streams = || map.streams.iter().zip(starts);
    let order = |a: &(&StreamEntry, &FirstMoment), b: &(&StreamEntry, &FirstMoment)| {
        a.1.t_s().total_cmp(&b.1.t_s())
    };
    let ((first, begin), (last, end)) = streams().min_by(order).zip(streams().max_by(order))?;
    let apart_s = end.t_s() - begin.t_s();
    (apart_s > MOST_APART_S).then(|| {
        let (last, first) = (last.name(), first.name());
        format!(
            "{last} begins {apart_s:.1e} s after {first}: their times count from different origins; give t_s an offset in the map of columns"
        )
    })
}

/// The file of a stream.
fn file_of(path: &Path, stream: &StreamEntry) -> Result<PathBuf> {
    match &stream.file {
        Some(file) if path.is_dir() => Ok(path.join(file)),
        None if !path.is_dir() => Ok(path.to_owned()),
        Some(file) => {
            // One file may be named for clearness; it must be this one.
            if path.file_name().is_some_and(|name| name == file.as_str()) {
                return Ok(path.to_owned());
            }
            let problem = format!("is not {file}, which the map names for {}", stream.name());
            Err(InputError::file(path, problem, "give the folder of the files").into())
        }
        None => {
            let problem = format!(
                "is a folder, and the map names no file for {}",
                stream.name()
            );
            Err(InputError::file(path, problem, "add file = \"…\" to the map").into())
        }
    }
}

impl StreamEntry {
    fn name(&self) -> String {
        format!("{}/{}", self.robot, self.kind.name())
    }
}

/// The first moment of a stream, and the unit of its clock (s).
#[derive(Debug, Clone, Copy, Default)]
struct FirstMoment {
    moment: Moment,
    unit_s: f64,
    offset_s: f64,
}

impl FirstMoment {
    /// The time on the clock of the file (s).
    fn t_s(&self) -> f64 {
        self.moment.since(Moment::default()) * self.unit_s + self.offset_s
    }

    /// The time since another start (s). On clocks of one unit, every digit is kept.
    fn since(&self, other: &Self) -> f64 {
        if self.unit_s == other.unit_s {
            return self.moment.since(other.moment) * self.unit_s
                + (self.offset_s - other.offset_s);
        }
        self.t_s() - other.t_s()
    }
}

fn start_of(file: &Path, stream: &StreamEntry) -> Result<FirstMoment> {
    let mut csv = ForeignCsv::open(file, stream.format)?;
    let mut clock = Clock::new(&csv, &stream.time)?;
    let mut first: Option<Moment> = None;
    while csv.next_row()? {
        if let Some(moment) = clock.moment(&csv)? {
            first = Some(first.map_or(moment, |first| first.earlier(moment)));
        }
    }
    let (unit_s, offset_s) = unit_of(&stream.time);
    Ok(FirstMoment {
        moment: first.unwrap_or_default(),
        unit_s,
        offset_s,
    })
}

/// Reads the rows of a stream. `starts` are those of this stream and of the recording. Returns also which rows
/// are left out.
fn read_stream(
    file: &Path,
    stream: &StreamEntry,
    starts: [FirstMoment; 2],
    disk: &Disk,
) -> Result<(Spool, Vec<String>)> {
    let mut csv = ForeignCsv::open(file, stream.format)?;
    let mut clock = Clock::new(&csv, &stream.time)?;
    let sources = stream.columns.iter().map(|(name, source)| {
        let source = source.try_map(|column| csv.find(column))?;
        Ok((*name, source))
    });
    let sources: Result<Vec<(&'static str, Source<Cell>)>> = sources.collect();
    let sources = sources?;
    let names: Vec<&'static str> = sources.iter().map(|(name, _)| *name).collect();
    let mut spool = Spool::new(disk, Table::new(&names, Vec::new()));
    let mut has_values = vec![false; names.len()];
    let [start, first] = &starts;
    let begin_s = start.since(first);
    while csv.next_row()? {
        let moment = clock.moment(&csv)?;
        let cells = sources
            .iter()
            .map(|(name, source)| cell(&csv, name, source));
        let cells: std::result::Result<Vec<f64>, InputError> = cells.collect();
        let cells = cells?;
        if cells.iter().all(|cell| cell.is_nan()) {
            continue;
        }
        let Some(moment) = moment else {
            return Err(csv
                .row_error("has no time", "give every row its time")
                .into());
        };
        let t_s = begin_s + moment.since(start.moment) * start.unit_s;
        if !is_time(t_s) {
            return Err(csv
                .row_error(format!("has the time {t_s} s"), "correct the factor")
                .into());
        }
        for (has_value, cell) in has_values.iter_mut().zip(&cells) {
            *has_value |= cell.is_finite();
        }
        spool.push_numbers(t_s, cells);
    }
    check(file, stream, &spool, &has_values)?;
    Ok((spool, csv.left_out()))
}

/// A value of the format; NaN if it is empty.
fn cell(
    csv: &ForeignCsv<'_>,
    name: &str,
    source: &Source<Cell>,
) -> std::result::Result<f64, InputError> {
    let cell = value(csv, source)?;
    if cell.is_nan() {
        return Ok(cell);
    }
    if name.starts_with("ticks") {
        if cell.fract() == 0.0 && cell.abs() < MAX_EXACT_INTEGER {
            return Ok(cell);
        }
        let problem = format!("{name} is {cell}, which is no whole number");
        return Err(csv.row_error(problem, "give counts, or map an angle"));
    }
    match out_of_range(name, cell) {
        Some(remedy) => Err(csv.row_error(format!("{name} is {cell}"), remedy)),
        None => Ok(cell),
    }
}

/// What a source has in the current row.
fn value(csv: &ForeignCsv<'_>, source: &Source<Cell>) -> std::result::Result<f64, InputError> {
    match source {
        Source::One(cell) => csv.number(*cell),
        Source::Direction([x, y]) => {
            let (x, y) = (csv.number(*x)?, csv.number(*y)?);
            Ok(if x == 0.0 && y == 0.0 {
                f64::NAN
            } else {
                y.atan2(x)
            })
        }
        Source::Quaternion([x, y], [z, w]) => {
            let or_0 = |cell: &Option<Cell>| cell.map_or(Ok(0.0), |cell| csv.number(cell));
            let (x, y, z, w) = (or_0(x)?, or_0(y)?, csv.number(*z)?, csv.number(*w)?);
            let size = (x * x + y * y + z * z + w * w).sqrt();
            // Some fill what they do not measure with zeros: NaN.
            let [x, y, z, w] = [x, y, z, w].map(|part| part / size);
            Ok(Quaternion { x, y, z, w }.yaw())
        }
    }
}

/// Refuses a stream without rows, or without any value in a column that it needs.
fn check(file: &Path, stream: &StreamEntry, spool: &Spool, has_values: &[bool]) -> Result<()> {
    let columns = stream.columns.iter().map(|(name, _)| *name).zip(has_values);
    let empty = columns.filter(|(name, has_value)| !**has_value && stream.kind.needs(name));
    let empty: Vec<&str> = empty.map(|(name, _)| name).collect();
    let problem = match &empty[..] {
        _ if spool.len() == 0 => format!("has no row for {}", stream.name()),
        [] => return Ok(()),
        _ => format!("has no value for {} of {}", empty.join(", "), stream.name()),
    };
    let remedy = "map another column, or leave the stream out";
    Err(InputError::file(file, problem, remedy).into())
}
