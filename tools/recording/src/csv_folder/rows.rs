//! One CSV file with a head: its rows, its cells, and errors with file and line.

use std::path::Path;
use std::sync::Arc;

use csv::{ByteRecord, ReaderBuilder, Trim};

use crate::error::Unusable;
use crate::recording::{Names, UnknownColumn};

/// One CSV file with a head, read row by row.
pub(crate) struct CsvFile<'a> {
    path: &'a Path,
    reader: csv::Reader<std::fs::File>,
    pub(crate) heads: Vec<String>,
    row: ByteRecord,
}

type Read<T> = Result<T, Unusable>;

impl<'a> CsvFile<'a> {
    pub(crate) fn open(path: &'a Path) -> Read<Self> {
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

    pub(crate) fn head_error(&self, problem: &str) -> Unusable {
        let remedy = "give a head line as the format describes it";
        Unusable::new(self.path, problem, remedy).at(1)
    }

    pub(crate) fn expect_first(&self, head: &str) -> Read<()> {
        match self.heads.first() {
            Some(first) if first == head => Ok(()),
            _ => Err(self.head_error(&format!("the first column is not {head}"))),
        }
    }

    /// Where each of `heads` stands.
    pub(crate) fn find<const N: usize>(&self, heads: &[&str; N]) -> [Option<usize>; N] {
        heads.map(|head| self.heads.iter().position(|known| known == head))
    }

    /// For each column of the file, its name if it is one of `heads`.
    pub(crate) fn known(&self, heads: &[&'static str]) -> Vec<Option<&'static str>> {
        let known = |name: &String| heads.iter().copied().find(|head| head == name);
        self.heads.iter().map(known).collect()
    }

    pub(crate) fn unknown_columns(
        &self,
        skip: usize,
        known: &[Option<&str>],
    ) -> Vec<UnknownColumn> {
        let heads = self.heads[skip..].iter().zip(known);
        heads
            .filter(|(_, known)| known.is_none())
            .map(|(head, _)| UnknownColumn {
                name: head.clone(),
                cells: Vec::new(),
            })
            .collect()
    }

    pub(crate) fn warn_of_unknown(
        &self,
        skip: usize,
        known: &[Option<&str>],
        warnings: &mut Vec<String>,
    ) {
        for column in self.unknown_columns(skip, known) {
            let path = self.path.display();
            warnings.push(format!(
                "{path}: unknown column {}; kept and ignored",
                column.name
            ));
        }
    }

    pub(crate) fn keep_unknown(
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
    pub(crate) fn next(&mut self) -> Read<bool> {
        let path = self.path;
        self.reader
            .read_byte_record(&mut self.row)
            .map_err(|e| csv_error(path, &e))
    }

    pub(crate) fn error(&self, problem: impl Into<String>, remedy: &str) -> Unusable {
        let line = self.row.position().map_or(0, csv::Position::line);
        Unusable::new(self.path, problem, remedy).at(line)
    }

    pub(crate) fn text(&self, column: usize) -> Read<&str> {
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

    pub(crate) fn number_or_nan(&self, column: usize) -> Read<f64> {
        Ok(self.number(column)?.unwrap_or(f64::NAN))
    }

    /// A time that is not before the one of the row before.
    pub(crate) fn time(&self, column: usize, before: Option<f64>) -> Read<f64> {
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
    pub(crate) fn count(&self, column: usize) -> Read<Option<i64>> {
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

    pub(crate) fn name(&self, column: usize, names: &mut Names) -> Read<Arc<str>> {
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
