//! A CSV file of others, read row by row: any separator, with or without a header, empty cells however they are written.

use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Trim};
use slipstream_bus::InputError;

use super::column_map::{Column, ColumnEntry, StreamEntry};

/// What stands in cells without a value, in small letters.
const EMPTY: [&str; 6] = ["", "nan", "na", "n/a", "null", "none"];

/// A file and its current row.
pub(super) struct ForeignCsv<'a> {
    path: &'a Path,
    reader: csv::Reader<std::fs::File>,
    header: Vec<String>,
    row: ByteRecord,
}

/// A moment as text says it: whole units and the rest, so that times since 1970 keep every digit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Moment {
    whole: i64,
    rest: f64,
}

impl Moment {
    /// The time since another moment, in the unit of the text.
    pub(super) fn since(self, other: Self) -> f64 {
        (self.whole.saturating_sub(other.whole)) as f64 + (self.rest - other.rest)
    }

    /// The earlier of two moments.
    pub(super) fn earlier(self, other: Self) -> Self {
        if other.since(self) < 0.0 { other } else { self }
    }

    fn parse(text: &str) -> Option<Self> {
        let is_plain = |c: char| c.is_ascii_digit() || c == '.' || c == '-' || c == '+';
        let whole = text.split('.').next().unwrap_or_default();
        if !text.chars().all(is_plain) || whole.starts_with('-') || whole.is_empty() {
            let number: f64 = text.parse().ok()?;
            let fits = number.is_finite() && number.abs() < 9e15;
            let moment = || Self {
                whole: number.floor() as i64,
                rest: number - number.floor(),
            };
            return fits.then(moment);
        }
        let rest = text.get(whole.len()..).unwrap_or_default();
        Some(Self {
            whole: whole.parse().ok()?,
            rest: match rest {
                "" | "." => 0.0,
                rest => rest.parse().ok()?,
            },
        })
    }
}

impl<'a> ForeignCsv<'a> {
    /// Opens the file of a stream.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn open(
        path: &'a Path,
        separator: u8,
        has_header: bool,
    ) -> Result<Self, InputError> {
        let file = std::fs::File::open(path).map_err(|e| InputError::unreadable(path, &e))?;
        let mut builder = ReaderBuilder::new();
        builder
            .trim(Trim::All)
            .delimiter(separator)
            .has_headers(has_header);
        let mut csv = Self {
            path,
            reader: builder.flexible(true).from_reader(file),
            header: Vec::new(),
            row: ByteRecord::new(),
        };
        if has_header {
            let header = csv
                .reader
                .byte_headers()
                .map_err(|e| unreadable(path, &e))?;
            let name = |cell: &[u8]| {
                let name = String::from_utf8_lossy(cell);
                name.trim_start_matches(['\u{feff}', '#', ' ']).to_owned()
            };
            csv.header = header.iter().map(name).collect();
        }
        Ok(csv)
    }

    /// Names of the columns; none without a header.
    pub(super) fn header(&self) -> &[String] {
        &self.header
    }

    /// The index of a column.
    ///
    /// # Errors
    /// If the header does not have it.
    pub(super) fn index(&self, entry: &ColumnEntry) -> Result<usize, InputError> {
        match &entry.column {
            Column::Number(number) => Ok(number - 1),
            Column::Name(name) => {
                let index = self.header.iter().position(|known| known == name);
                index.ok_or_else(|| {
                    let remedy = format!("name one of: {}", self.header.join(", "));
                    InputError::file(self.path, format!("has no column {name}"), remedy).at(1)
                })
            }
        }
    }

    /// Reads the next row. Returns whether there is one.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(super) fn next_row(&mut self) -> Result<bool, InputError> {
        let path = self.path;
        let read = self.reader.read_byte_record(&mut self.row);
        read.map_err(|e| unreadable(path, &e))
    }

    /// The text of a cell; `None` if it is empty.
    fn cell(&self, index: usize) -> Result<Option<&str>, InputError> {
        let Some(bytes) = self.row.get(index) else {
            let problem = format!("has no column {} in this row", index + 1);
            return Err(self.row_error(problem, "correct the separator, or the row"));
        };
        let text = std::str::from_utf8(bytes);
        let text = text.map_err(|_| self.row_error("is not UTF-8", "save the file as UTF-8"))?;
        let is_empty = EMPTY.iter().any(|empty| text.eq_ignore_ascii_case(empty));
        Ok((!is_empty).then_some(text))
    }

    /// A cell as a number; NaN if it is empty.
    ///
    /// # Errors
    /// If it is not a finite number.
    pub(super) fn number(&self, index: usize) -> Result<f64, InputError> {
        let Some(text) = self.cell(index)? else {
            return Ok(f64::NAN);
        };
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.not_a_number(index, text))
    }

    /// A cell as a moment; `None` if it is empty.
    ///
    /// # Errors
    /// If it is not a finite number.
    pub(super) fn moment(&self, index: usize) -> Result<Option<Moment>, InputError> {
        let Some(text) = self.cell(index)? else {
            return Ok(None);
        };
        let moment = Moment::parse(text);
        moment
            .map(Some)
            .ok_or_else(|| self.not_a_number(index, text))
    }

    fn not_a_number(&self, index: usize, text: &str) -> InputError {
        let number = (index + 1).to_string();
        let name = self.header.get(index).unwrap_or(&number);
        let problem = format!("column {name} has \"{text}\"");
        self.row_error(
            problem,
            "give numbers with a decimal point; a time is one number",
        )
    }

    /// An error about the current row.
    pub(super) fn row_error(&self, problem: impl Into<String>, remedy: &str) -> InputError {
        let line = self.row.position().map_or(0, csv::Position::line);
        InputError::file(self.path, problem, remedy).at(line)
    }
}

impl StreamEntry {
    /// Opens the file of the stream.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn open<'a>(&self, path: &'a Path) -> Result<ForeignCsv<'a>, InputError> {
        ForeignCsv::open(path, self.separator, self.has_header)
    }
}

fn unreadable(path: &Path, error: &csv::Error) -> InputError {
    let error = error.to_string().replace('\n', " ");
    InputError::file(path, format!("cannot be read: {error}"), "give a CSV file")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_since_1970_keep_their_digits() {
        let moment = |text| Moment::parse(text).unwrap();
        let start = moment("1700000000.000000001");
        assert_eq!(moment("1700000001.000000002").since(start), 1.0 + 1e-9);
        assert_eq!(
            moment("1700000000000123456").since(moment("1700000000000000000")),
            123_456.0
        );
        assert_eq!(moment("-0.5").since(moment("1e0")), -1.5);
        assert_eq!(Moment::parse("12:30"), None);
        assert_eq!(Moment::parse("inf"), None);
    }
}
