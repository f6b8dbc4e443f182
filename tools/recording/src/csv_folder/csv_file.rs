//! One CSV file with a header line, read row by row; errors name file and line.

use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Trim};
use slipstream_bag::refuse_pointer;
use slipstream_bus::InputError;

use crate::recording::UnknownColumn;
use crate::table::out_of_range;

type CsvResult<T> = Result<T, InputError>;

/// Integers of a smaller size are exact in floating point (2^53).
const MAX_EXACT_INTEGER: f64 = 9_007_199_254_740_992.0;

/// A CSV file with a header line, and its current row. Columns are numbered from 0.
pub(super) struct CsvFile<'a> {
    path: &'a Path,
    reader: csv::Reader<std::fs::File>,
    /// Names of the columns.
    pub(super) header: Vec<String>,
    row: ByteRecord,
}

impl<'a> CsvFile<'a> {
    /// Opens a file and reads its header.
    ///
    /// # Errors
    /// If the file cannot be read or is empty, or if a column name occurs twice.
    pub(super) fn open(path: &'a Path) -> CsvResult<Self> {
        let file = std::fs::File::open(path).map_err(|e| InputError::unreadable(path, &e))?;
        let mut reader = ReaderBuilder::new().trim(Trim::All).from_reader(file);
        let header = reader.headers().map_err(|e| csv_error(path, &e))?;
        refuse_pointer(header.as_slice().as_bytes(), path)?;
        let header: Vec<String> = header.iter().map(str::to_owned).collect();
        let file = Self {
            path,
            reader,
            header,
            row: ByteRecord::new(),
        };
        if file.header.is_empty() {
            return Err(file.header_error("the file is empty"));
        }
        let is_repeated = |(i, name): (usize, &String)| file.header[..i].contains(name);
        let repeated = file
            .header
            .iter()
            .enumerate()
            .find(|&pair| is_repeated(pair));
        match repeated {
            Some((_, name)) => Err(file.header_error(&format!("column {name} occurs twice"))),
            None => Ok(file),
        }
    }

    /// An error about the header.
    pub(super) fn header_error(&self, problem: &str) -> InputError {
        let remedy = "give a header line as the format defines it";
        InputError::file(self.path, problem, remedy).at(1)
    }

    /// Checks the name of the first column.
    ///
    /// # Errors
    /// If it is another one.
    pub(super) fn expect_first(&self, name: &str) -> CsvResult<()> {
        match self.header.first() {
            Some(first) if first == name => Ok(()),
            _ => Err(self.header_error(&format!("the first column is not {name}"))),
        }
    }

    /// The index of each of these columns, if present.
    pub(super) fn find<const N: usize>(&self, names: &[&str; N]) -> [Option<usize>; N] {
        names.map(|name| self.header.iter().position(|known| known == name))
    }

    /// For each column of the file its name, if it is one of `names`.
    pub(super) fn known(&self, names: &[&'static str]) -> Vec<Option<&'static str>> {
        let known = |column: &String| names.iter().copied().find(|name| name == column);
        self.header.iter().map(known).collect()
    }

    /// The columns whose entry in `known` is `None`, without cells. `known` begins with column
    /// number `skip`, here and in the two functions below.
    pub(super) fn unknown_columns(
        &self,
        skip: usize,
        known: &[Option<&str>],
    ) -> Vec<UnknownColumn> {
        let columns = self.header[skip..].iter().zip(known);
        columns
            .filter(|(_, known)| known.is_none())
            .map(|(name, _)| UnknownColumn::named(name))
            .collect()
    }

    /// Adds a warning for each unknown column.
    pub(super) fn warn_of_unknown(
        &self,
        skip: usize,
        known: &[Option<&str>],
        warnings: &mut Vec<String>,
    ) {
        for column in self.unknown_columns(skip, known) {
            let path = self.path.display();
            warnings.push(format!(
                "{path}: unknown column {}; kept as text, not used",
                column.name
            ));
        }
    }

    /// Appends the current row's cells of the unknown columns.
    ///
    /// # Errors
    /// If a cell is not UTF-8.
    pub(super) fn keep_unknown(
        &self,
        skip: usize,
        known: &[Option<&str>],
        unknown: &mut [UnknownColumn],
    ) -> CsvResult<()> {
        let indices = known.iter().enumerate().filter(|(_, name)| name.is_none());
        for ((i, _), column) in indices.zip(unknown) {
            column.cells.push(self.text(skip + i)?.to_owned());
        }
        Ok(())
    }

    /// Reads the next row. Returns whether there is one.
    ///
    /// # Errors
    /// If the file cannot be read or the row has another number of cells than the header.
    pub(super) fn next_row(&mut self) -> CsvResult<bool> {
        let path = self.path;
        self.reader
            .read_byte_record(&mut self.row)
            .map_err(|e| csv_error(path, &e))
    }

    /// An error about the current row.
    pub(super) fn row_error(&self, problem: impl Into<String>, remedy: &str) -> InputError {
        let line = self.row.position().map_or(0, csv::Position::line);
        InputError::file(self.path, problem, remedy).at(line)
    }

    /// A cell of the current row as text.
    ///
    /// # Errors
    /// If it is not UTF-8.
    pub(super) fn text(&self, column: usize) -> CsvResult<&str> {
        let bytes = self.row.get(column).unwrap_or_default();
        std::str::from_utf8(bytes).map_err(|_| {
            let problem = format!("{} is not UTF-8", self.column_name(column));
            self.row_error(problem, "save the file as UTF-8")
        })
    }

    fn column_name(&self, column: usize) -> &str {
        self.header.get(column).map_or("", String::as_str)
    }

    fn number(&self, column: usize) -> CsvResult<Option<f64>> {
        let number = self.finite(column)?;
        let name = self.column_name(column);
        match number.and_then(|number| out_of_range(name, number)) {
            Some(remedy) => {
                Err(self.row_error(format!("{name} is \"{}\"", self.text(column)?), remedy))
            }
            None => Ok(number),
        }
    }

    fn finite(&self, column: usize) -> CsvResult<Option<f64>> {
        let text = self.text(column)?;
        if text.is_empty() {
            return Ok(None);
        }
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Some(number)),
            _ => Err(self.row_error(
                format!("{} is \"{text}\"", self.column_name(column)),
                "give a finite number, or leave the cell empty",
            )),
        }
    }

    /// A cell as a number; NaN if it is empty.
    ///
    /// # Errors
    /// If it is not a finite number, or larger than any robot's.
    pub(super) fn number_or_nan(&self, column: usize) -> CsvResult<f64> {
        Ok(self.number(column)?.unwrap_or(f64::NAN))
    }

    /// A cell as a time (s) that is not earlier than that of the previous row.
    ///
    /// # Errors
    /// If it is empty, not a finite number, cannot be represented, or is earlier.
    pub(super) fn time(&self, column: usize, previous: Option<f64>) -> CsvResult<f64> {
        let name = self.column_name(column);
        let Some(t_s) = self.number(column)? else {
            return Err(self.row_error(format!("{name} is empty"), "give every row its time"));
        };
        match previous {
            Some(previous) if t_s < previous => Err(self.row_error(
                format!("{name} runs backwards, from {previous} to {t_s}"),
                "sort the rows by time, or cut the recording where the clock was set",
            )),
            _ => Ok(t_s),
        }
    }

    /// A cell as a whole number, which may be written as `12.0`; `None` if it is empty.
    ///
    /// # Errors
    /// If it is not a whole number.
    pub(super) fn count(&self, column: usize) -> CsvResult<Option<i64>> {
        let text = self.text(column)?;
        if let Ok(count) = text.parse() {
            return Ok(Some(count));
        }
        match self.finite(column)? {
            None => Ok(None),
            Some(number) if number.fract() == 0.0 && number.abs() < MAX_EXACT_INTEGER => {
                Ok(Some(number as i64))
            }
            Some(_) => Err(self.row_error(
                format!("{} is \"{text}\"", self.column_name(column)),
                "give a whole number",
            )),
        }
    }

    /// A cell as the name of a robot.
    ///
    /// # Errors
    /// If it is empty.
    pub(super) fn name(&self, column: usize) -> CsvResult<&str> {
        match self.text(column)? {
            "" => Err(self.row_error(
                format!("{} is empty", self.column_name(column)),
                "give the robot's name",
            )),
            name => Ok(name),
        }
    }
}

/// Converts an error of the CSV library.
fn csv_error(path: &Path, error: &csv::Error) -> InputError {
    let line = error.position().map(csv::Position::line);
    let (problem, remedy) = match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => (
            format!("{len} cells in a row, {expected_len} in the header"),
            "give every row as many cells as the header",
        ),
        csv::ErrorKind::Utf8 { .. } => ("is not UTF-8".to_owned(), "save the file as UTF-8"),
        csv::ErrorKind::Io(e) => (e.to_string(), "check the path and its permissions"),
        _ => (error.to_string(), "correct the CSV syntax"),
    };
    let error = InputError::file(path, problem, remedy);
    match line {
        Some(line) => error.at(line),
        None => error,
    }
}
