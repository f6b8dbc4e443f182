//! A text file of others, read row by row: any layout, empty cells however they are written.

use std::path::Path;

use slipstream_bus::InputError;

use super::entry::{Column, ColumnEntry, FileFormat};
use super::layout::{Layout, Sample};
use super::lines::{CellsOfLine, Lines, comment};
use super::moment::with_point;

/// What stands in cells without a value, in small letters.
const EMPTY: [&str; 7] = ["", "nan", "na", "n/a", "null", "none", "-"];

/// A file and its current row.
pub(super) struct ForeignCsv<'a> {
    pub(super) path: &'a Path,
    layout: Layout,
    lines: Lines,
    row: CellsOfLine,
    /// The line of a last row that was cut, and is left out.
    cut_at: Option<u64>,
    /// So many rows above the data are still to come.
    rows_above: usize,
}

/// A column of a file by its place, and how to convert its cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// From 0 on.
    pub(super) index: usize,
    factor: f64,
    offset: f64,
}

impl<'a> ForeignCsv<'a> {
    /// Opens a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn open(path: &'a Path, format: FileFormat) -> Result<Self, InputError> {
        let layout = Sample::read(path, format)?.layout;
        Ok(Self {
            path,
            lines: Lines::open(path)?,
            row: CellsOfLine::default(),
            cut_at: None,
            rows_above: layout.rows_above,
            layout,
        })
    }

    /// The place of a column.
    ///
    /// # Errors
    /// If the header does not have it.
    pub(super) fn find(&self, entry: &ColumnEntry) -> Result<Cell, InputError> {
        let names = &self.layout.names;
        let index = match &entry.column {
            Column::Number(number) => number - 1,
            Column::Name(name) => {
                // A comment's mark may stand before the first name.
                let plain = name.trim_start_matches(['#', '%', '/', ' ']);
                let find = |name: &str| names.iter().position(|known| known == name);
                let index = find(name).or_else(|| find(plain));
                index.ok_or_else(|| self.no_column(name))?
            }
        };
        Ok(Cell {
            index,
            factor: entry.factor,
            offset: entry.offset,
        })
    }

    fn no_column(&self, name: &str) -> InputError {
        let remedy = match self.layout.names.as_slice() {
            [] => "it has no header: give the column's number, from 1 on".to_owned(),
            names => format!("name one of: {}", names.join(", ")),
        };
        InputError::file(self.path, format!("has no column {name}"), remedy).at(1)
    }

    /// Reads the next row. Returns whether there is one.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(super) fn next_row(&mut self) -> Result<bool, InputError> {
        while let Some(line) = self.lines.next()? {
            if comment(line).is_some() {
                continue;
            }
            if self.rows_above > 0 {
                self.rows_above -= 1;
                continue;
            }
            self.row.split(line, self.layout.separator);
            // The last row of a log that was cut.
            let is_short = self.row.len() < self.layout.columns;
            if is_short && !self.lines.is_ended {
                self.cut_at = Some(self.lines.number);
                return Ok(false);
            }
            return Ok(true);
        }
        Ok(false)
    }

    /// What was left out so far.
    pub(super) fn left_out(&self) -> Vec<String> {
        let rows = self.layout.preamble_rows;
        let preamble = format!("the first {rows} rows are no part of the table");
        let preamble = (rows > 0).then_some(preamble);
        let cut = self
            .cut_at
            .map(|line| format!("line {line}, the last row, is cut"));
        preamble.into_iter().chain(cut).collect()
    }

    /// The text of a cell; `None` if it is empty.
    ///
    /// # Errors
    /// If the row has no such cell, or it is not text.
    pub(super) fn text(&self, index: usize) -> Result<Option<&str>, InputError> {
        let Some(bytes) = self.row.get(index) else {
            let problem = format!("has no column {} in this row", index + 1);
            return Err(self.row_error(problem, "correct the separator, or the row"));
        };
        let text = std::str::from_utf8(bytes);
        let text = text.map_err(|_| self.row_error("is not UTF-8", "save the file as UTF-8"))?;
        let is_empty = EMPTY.iter().any(|empty| text.eq_ignore_ascii_case(empty));
        Ok((!is_empty).then_some(text))
    }

    /// A cell as a number in the unit of the format; NaN if it is empty.
    ///
    /// # Errors
    /// If it is not a finite number.
    pub(super) fn number(&self, cell: Cell) -> Result<f64, InputError> {
        let Some(text) = self.text(cell.index)? else {
            return Ok(f64::NAN);
        };
        let number = text.parse().or_else(|_| with_point(text).parse()).ok();
        let number = number.filter(|number: &f64| number.is_finite());
        let number = number.ok_or_else(|| self.not_a_number(cell.index, text))?;
        Ok(number * cell.factor + cell.offset)
    }

    /// An error about a cell.
    pub(super) fn not_a_number(&self, index: usize, text: &str) -> InputError {
        let number = (index + 1).to_string();
        let name = self.layout.names.get(index).unwrap_or(&number);
        let problem = format!("column {name} has \"{text}\"");
        self.row_error(
            problem,
            "give numbers with a decimal point; a time is a number, or a date and time without a factor",
        )
    }

    /// An error about the current row.
    pub(super) fn row_error(&self, problem: impl Into<String>, remedy: &str) -> InputError {
        InputError::file(self.path, problem, remedy).at(self.lines.number)
    }
}
