//! CSV folders in: every stream as it is written, errors with file and line.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use csv::{ByteRecord, ReaderBuilder, Trim};

use crate::bag::reader::Loss;
use crate::build::Names;
use crate::error::{Result, Unusable};
use crate::recording::{LinkMessage, Links, Recording, Robot, RoundTrips, UnknownColumn};
use crate::table::{Cells, ColumnSet, StreamKind, Table};
use crate::toml_file::read_text;
use crate::{recording_toml, robot_toml};

/// A recording that was read, and what a user should know about how.
#[derive(Debug)]
pub struct Import {
    /// The recording.
    pub recording: Recording,
    /// One line each: what was ignored, guessed or lost.
    pub warnings: Vec<String>,
    /// What of an MCAP file could not be read; `None` for folders.
    pub loss: Option<Loss>,
    /// Messages of an MCAP file that the in-memory form has no place for, by topic.
    pub left_out: BTreeMap<String, u64>,
}

/// Reads a folder of CSV files.
///
/// # Errors
/// The first thing that is not as the format wants it, with file and line.
pub fn read_folder(folder: &Path) -> Result<Import> {
    let path = folder.join("recording.toml");
    let name = folder.file_name().map(|name| name.to_string_lossy());
    let text = read_text(&path)?;
    let mut recording = recording_toml::parse(&text, &path, &name.unwrap_or_default())?;
    let mut warnings = Vec::new();
    let model = folder.join("robot.toml");
    if model.exists() {
        recording.model = Some(robot_toml::read(&model)?);
    }
    for entry in sorted_entries(folder)? {
        read_entry(&entry, &mut recording, &mut warnings)?;
    }
    Ok(Import {
        recording,
        warnings,
        loss: None,
        left_out: BTreeMap::new(),
    })
}

fn sorted_entries(folder: &Path) -> std::result::Result<Vec<PathBuf>, Unusable> {
    let unreadable = |e| Unusable::unreadable(folder, &e);
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        paths.push(entry.map_err(unreadable)?.path());
    }
    paths.sort();
    Ok(paths)
}

/// One entry of the recording's folder: a robot's folder or a file of the whole recording.
fn read_entry(path: &Path, recording: &mut Recording, warnings: &mut Vec<String>) -> Result<()> {
    let name = file_name(path);
    match name.as_str() {
        "recording.toml" | "robot.toml" => {}
        "links.csv" => recording.links = Some(read_links(path, warnings)?),
        "rtt.csv" => recording.rtt = Some(read_rtt(path, warnings)?),
        _ if path.is_dir() => {
            let Some(robot) = robot_of_folder(path, &name, recording, warnings) else {
                return Ok(());
            };
            for file in sorted_entries(path)? {
                read_stream(&file, robot, warnings)?;
            }
        }
        _ => warnings.push(format!(
            "{}: no file of the format; ignored",
            path.display()
        )),
    }
    Ok(())
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy());
    name.unwrap_or_default().into_owned()
}

/// The robot whose folder this is. A folder without a table counts if it holds a stream.
fn robot_of_folder<'a>(
    path: &Path,
    name: &str,
    recording: &'a mut Recording,
    warnings: &mut Vec<String>,
) -> Option<&'a mut Robot> {
    if let Some(at) = recording.robots.iter().position(|r| r.name == name) {
        return recording.robots.get_mut(at);
    }
    let has_stream = |kind: &StreamKind| path.join(format!("{}.csv", kind.name())).exists();
    let is_robot = StreamKind::ALL.iter().any(has_stream);
    if !is_robot || !crate::recording::is_robot_name(name) {
        warnings.push(format!("{}: no robot's folder; ignored", path.display()));
        return None;
    }
    warnings.push(format!(
        "{}: recording.toml has no [robots.{name}]; taken as a robot of which nothing is known",
        path.display()
    ));
    recording.robots.push(Robot::named(name));
    recording.robots.last_mut()
}

fn read_stream(path: &Path, robot: &mut Robot, warnings: &mut Vec<String>) -> Result<()> {
    let name = file_name(path);
    let Some(kind) = name.strip_suffix(".csv").and_then(StreamKind::from_name) else {
        warnings.push(format!(
            "{}: no file of the format; ignored",
            path.display()
        ));
        return Ok(());
    };
    let mut file = CsvFile::open(path)?;
    file.expect_first("t_s")?;
    let known: Vec<Option<&'static str>> = file.heads[1..].iter().map(|h| kind.column(h)).collect();
    let present: Vec<&'static str> = known.iter().copied().flatten().collect();
    ColumnSet::choose(kind, &present)
        .map_err(|(problem, remedy)| Unusable::new(path, problem, remedy).at(1))?;
    file.warn_of_unknown(1, &known, warnings);

    let mut table = Table::default();
    let mut columns: Vec<(&'static str, Cells)> = present
        .iter()
        .map(|name| (*name, Cells::of(name)))
        .collect();
    let mut unknown = file.unknown_columns(1, &known);
    while file.next()? {
        let t_s = file.time(0, table.t_s.last().copied())?;
        table.t_s.push(t_s);
        let (mut at_known, mut at_unknown) = (columns.iter_mut(), unknown.iter_mut());
        for (i, column) in known.iter().enumerate() {
            match column {
                Some(_) => match at_known.next() {
                    Some((_, Cells::Numbers(cells))) => cells.push(file.number_or_nan(i + 1)?),
                    Some((_, Cells::Counts(cells))) => cells.push(file.count(i + 1)?),
                    None => {}
                },
                None => {
                    if let Some(column) = at_unknown.next() {
                        column.cells.push(file.text(i + 1)?.to_owned());
                    }
                }
            }
        }
    }
    table.columns = columns;
    table.unknown = unknown;
    table.give_to(robot, kind);
    Ok(())
}

const LINK_HEADS: [&str; 9] = [
    "t_sent_s",
    "t_received_s",
    "from",
    "to",
    "x_m",
    "y_m",
    "yaw_rad",
    "v_m_s",
    "w_rad_s",
];

fn read_links(path: &Path, warnings: &mut Vec<String>) -> Result<Links> {
    let mut file = CsvFile::open(path)?;
    file.expect_first("t_sent_s")?;
    let [.., v, w] = file.find(&LINK_HEADS);
    for (head, at) in LINK_HEADS.iter().zip(file.find(&LINK_HEADS)).take(7) {
        if at.is_none() {
            return Err(file.head_error(&format!("column {head} is missing")).into());
        }
    }
    if v.is_some() != w.is_some() {
        return Err(file.head_error("only one of v_m_s, w_rad_s").into());
    }
    let known = file.known(&LINK_HEADS);
    file.warn_of_unknown(0, &known, warnings);
    let mut links = Links {
        with_velocity: v.is_some(),
        unknown: file.unknown_columns(0, &known),
        ..Links::default()
    };
    let mut names = Names::default();
    let [sent, received, from, to, x, y, yaw, ..] =
        file.find(&LINK_HEADS).map(Option::unwrap_or_default);
    while file.next()? {
        let before = links.messages.last().map(|message| message.t_sent_s);
        let velocity = |at: Option<usize>| at.map_or(Ok(f64::NAN), |at| file.number_or_nan(at));
        let message = LinkMessage {
            t_sent_s: file.time(sent, before)?,
            t_received_s: Some(file.number_or_nan(received)?).filter(|t| !t.is_nan()),
            from: file.name(from, &mut names)?,
            to: file.name(to, &mut names)?,
            x_m: file.number_or_nan(x)?,
            y_m: file.number_or_nan(y)?,
            yaw_rad: file.number_or_nan(yaw)?,
            v_m_s: velocity(v)?,
            w_rad_s: velocity(w)?,
        };
        links.messages.push(message);
        file.keep_unknown(0, &known, &mut links.unknown)?;
    }
    Ok(links)
}

const RTT_HEADS: [&str; 2] = ["seq", "rtt_ms"];

fn read_rtt(path: &Path, warnings: &mut Vec<String>) -> Result<RoundTrips> {
    let mut file = CsvFile::open(path)?;
    let [Some(seq), Some(rtt)] = file.find(&RTT_HEADS) else {
        return Err(file.head_error("not both of seq, rtt_ms").into());
    };
    let known = file.known(&RTT_HEADS);
    file.warn_of_unknown(0, &known, warnings);
    let mut trips = RoundTrips {
        unknown: file.unknown_columns(0, &known),
        ..RoundTrips::default()
    };
    while file.next()? {
        let Some(seq) = file.count(seq)? else {
            return Err(file.error("seq is empty", "number the round trips").into());
        };
        trips.seq.push(seq);
        trips.rtt_ms.push(file.number_or_nan(rtt)?);
        file.keep_unknown(0, &known, &mut trips.unknown)?;
    }
    Ok(trips)
}

/// One CSV file with a head, read row by row.
struct CsvFile<'a> {
    path: &'a Path,
    reader: csv::Reader<std::fs::File>,
    heads: Vec<String>,
    row: ByteRecord,
}

type Read<T> = std::result::Result<T, Unusable>;

impl<'a> CsvFile<'a> {
    fn open(path: &'a Path) -> Read<Self> {
        let file = std::fs::File::open(path).map_err(|e| Unusable::unreadable(path, &e))?;
        let mut reader = ReaderBuilder::new().trim(Trim::All).from_reader(file);
        let heads = reader.headers().map_err(|e| csv_error(path, &e))?;
        let heads: Vec<String> = heads.iter().map(str::to_owned).collect();
        let file = Self {
            path,
            reader,
            heads,
            row: ByteRecord::new(),
        };
        if file.heads.is_empty() {
            return Err(file.head_error("the file is empty"));
        }
        let twice = |(i, head): (usize, &String)| file.heads[..i].contains(head);
        match file.heads.iter().enumerate().find(|&pair| twice(pair)) {
            Some((_, head)) => Err(file.head_error(&format!("column {head} twice"))),
            None => Ok(file),
        }
    }

    fn head_error(&self, problem: &str) -> Unusable {
        let remedy = "give a head line as the format describes it";
        Unusable::new(self.path, problem, remedy).at(1)
    }

    fn expect_first(&self, head: &str) -> Read<()> {
        match self.heads.first() {
            Some(first) if first == head => Ok(()),
            _ => Err(self.head_error(&format!("the first column is not {head}"))),
        }
    }

    /// Where each of `heads` stands.
    fn find<const N: usize>(&self, heads: &[&str; N]) -> [Option<usize>; N] {
        heads.map(|head| self.heads.iter().position(|known| known == head))
    }

    /// For each column of the file, its name if it is one of `heads`.
    fn known(&self, heads: &[&'static str]) -> Vec<Option<&'static str>> {
        let known = |name: &String| heads.iter().copied().find(|head| head == name);
        self.heads.iter().map(known).collect()
    }

    fn unknown_columns(&self, skip: usize, known: &[Option<&str>]) -> Vec<UnknownColumn> {
        let heads = self.heads[skip..].iter().zip(known);
        heads
            .filter(|(_, known)| known.is_none())
            .map(|(head, _)| UnknownColumn {
                name: head.clone(),
                cells: Vec::new(),
            })
            .collect()
    }

    fn warn_of_unknown(&self, skip: usize, known: &[Option<&str>], warnings: &mut Vec<String>) {
        for column in self.unknown_columns(skip, known) {
            let path = self.path.display();
            warnings.push(format!(
                "{path}: unknown column {}; kept and ignored",
                column.name
            ));
        }
    }

    fn keep_unknown(
        &self,
        skip: usize,
        known: &[Option<&str>],
        unknown: &mut [UnknownColumn],
    ) -> Read<()> {
        let mut columns = unknown.iter_mut();
        for (i, _) in known
            .iter()
            .enumerate()
            .filter(|(_, known)| known.is_none())
        {
            if let Some(column) = columns.next() {
                column.cells.push(self.text(skip + i)?.to_owned());
            }
        }
        Ok(())
    }

    /// Goes to the next row, if there is one.
    fn next(&mut self) -> Read<bool> {
        let path = self.path;
        self.reader
            .read_byte_record(&mut self.row)
            .map_err(|e| csv_error(path, &e))
    }

    fn error(&self, problem: impl Into<String>, remedy: &str) -> Unusable {
        let line = self.row.position().map_or(0, csv::Position::line);
        Unusable::new(self.path, problem, remedy).at(line)
    }

    fn text(&self, column: usize) -> Read<&str> {
        let bytes = self.row.get(column).unwrap_or_default();
        std::str::from_utf8(bytes).map_err(|_| {
            let problem = format!("{} is no UTF-8", self.head(column));
            self.error(problem, "save the file as UTF-8")
        })
    }

    fn head(&self, column: usize) -> &str {
        self.heads.get(column).map_or("", String::as_str)
    }

    fn number(&self, column: usize) -> Read<Option<f64>> {
        let text = self.text(column)?;
        if text.is_empty() {
            return Ok(None);
        }
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Some(number)),
            _ => Err(self.error(
                format!("{} is \"{text}\"", self.head(column)),
                "give a finite number, or leave the cell empty",
            )),
        }
    }

    fn number_or_nan(&self, column: usize) -> Read<f64> {
        Ok(self.number(column)?.unwrap_or(f64::NAN))
    }

    /// A time that is not before the one of the row before.
    fn time(&self, column: usize, before: Option<f64>) -> Read<f64> {
        let head = self.head(column);
        let Some(t_s) = self.number(column)? else {
            return Err(self.error(format!("{head} is empty"), "give every row its time"));
        };
        match before {
            Some(before) if t_s < before => Err(self.error(
                format!("{head} runs backwards, from {before} to {t_s}"),
                "sort the rows by time, or cut the recording where the clock was set",
            )),
            _ => Ok(t_s),
        }
    }

    /// A whole number; `12.0` is one too.
    fn count(&self, column: usize) -> Read<Option<i64>> {
        let text = self.text(column)?;
        if let Ok(count) = text.parse() {
            return Ok(Some(count));
        }
        match self.number(column)? {
            None => Ok(None),
            Some(number) if number.fract() == 0.0 && number.abs() < WHOLE => {
                Ok(Some(number as i64))
            }
            Some(_) => Err(self.error(
                format!("{} is \"{text}\"", self.head(column)),
                "give a whole number",
            )),
        }
    }

    fn name(&self, column: usize, names: &mut Names) -> Read<Arc<str>> {
        match self.text(column)? {
            "" => Err(self.error(
                format!("{} is empty", self.head(column)),
                "give the robot's name",
            )),
            name => Ok(names.get(name)),
        }
    }
}

/// Above this (2^53), a number in floating point need not be the whole number that was meant.
const WHOLE: f64 = 9_007_199_254_740_992.0;

fn csv_error(path: &Path, error: &csv::Error) -> Unusable {
    let line = error.position().map(csv::Position::line);
    let (problem, remedy) = match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => (
            format!("{len} cells in a row, {expected_len} in the head"),
            "give every row as many cells as the head",
        ),
        csv::ErrorKind::Utf8 { .. } => ("no UTF-8".to_owned(), "save the file as UTF-8"),
        csv::ErrorKind::Io(e) => (e.to_string(), "check the name and its rights"),
        _ => (error.to_string(), "write it as CSV"),
    };
    let unusable = Unusable::new(path, problem, remedy);
    match line {
        Some(line) => unusable.at(line),
        None => unusable,
    }
}
