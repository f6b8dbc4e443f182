//! Layout of a text file, recognised from its first rows: separator, header, names of the columns.

use std::path::Path;

use slipstream_bag::refuse_pointer;
use slipstream_bus::InputError;

use super::entry::FileFormat;
use super::lines::{CellsOfLine, Lines, comment, text};

/// So many rows tell the layout.
const SAMPLE_ROWS: usize = 60;
/// No row is added to a sample of so many bytes.
const SAMPLE_BYTES: usize = 1 << 20;
/// Separators, the first of several that fit alike is taken; a blank stands for a run of blanks and tabs.
const SEPARATORS: [u8; 4] = [b'\t', b';', b',', b' '];

/// How a file is laid out.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    pub(super) separator: u8,
    /// Number of cells of a row.
    pub(super) columns: usize,
    /// So many rows stand above the data: perhaps one with the names, one with units, and others.
    pub(super) rows_above: usize,
    /// So many of these are neither names nor units.
    pub(super) preamble_rows: usize,
    /// The names of the columns, from the first row or the last comment before it; empty if there are none.
    pub(super) names: Vec<String>,
    /// The units below the names; empty if there is no such row.
    pub(super) units: Vec<String>,
}

/// The beginning of a file.
#[derive(Debug)]
pub(super) struct Sample {
    pub(super) layout: Layout,
    /// The first rows without the header.
    pub(super) rows: Vec<Vec<String>>,
}

/// The first lines of a file.
struct Beginning {
    /// The last comment before the first row.
    comment: Option<Vec<u8>>,
    rows: Vec<Vec<u8>>,
}

impl Sample {
    /// Reads the beginning of a file. What `said` says is not guessed.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn read(path: &Path, said: FileFormat) -> Result<Self, InputError> {
        let beginning = Beginning::read(path)?;
        let separator = said.separator.unwrap_or_else(|| beginning.separator());
        let rows = beginning.rows.iter().map(|line| cells(line, separator));
        let mut rows: Vec<Vec<String>> = rows.collect();
        let columns = most_frequent(rows.iter().map(Vec::len)).unwrap_or(0);
        let above = rows_above(&rows, columns, said, beginning.comment.is_some());
        let data = rows.split_off(above.min(rows.len()));
        let (mut names, units) = match said.has_header {
            Some(false) => (Vec::new(), Vec::new()),
            said => names_in(&rows, columns, said.is_some()),
        };
        if rows.is_empty() && said.has_header != Some(false) {
            names = beginning.names_in_comment(separator, columns);
        }
        let named = usize::from(!names.is_empty()) + usize::from(!units.is_empty());
        let ends_empty = |row: &Vec<String>| row.last().is_some_and(String::is_empty);
        // The names of rows, which R writes, have no name.
        if names.len() + 1 == columns && !names.is_empty() && !data.iter().all(ends_empty) {
            names.insert(0, String::new());
        }
        Ok(Self {
            layout: Layout {
                separator,
                columns,
                rows_above: rows.len(),
                preamble_rows: rows.len().saturating_sub(named),
                names,
                units,
            },
            rows: data,
        })
    }
}

/// How many rows stand above the data.
fn rows_above(rows: &[Vec<String>], columns: usize, said: FileFormat, has_comment: bool) -> usize {
    let is_data = |row: &Vec<String>| match numbers(row) {
        0 => false,
        numbers => row.len() == columns || numbers * 2 > row.len(),
    };
    match said.has_header {
        None => rows.iter().position(is_data).unwrap_or(1),
        Some(false) => {
            let is_prose = |row: &&Vec<String>| row.len() != columns && !is_data(row);
            rows.iter().take_while(is_prose).count()
        }
        Some(true) => {
            let has_numbers = rows.first().is_some_and(|row| numbers(row) > 0);
            usize::from(!(has_numbers && has_comment))
        }
    }
}

/// The names and the units in the rows above the data. Rows may end with a separator that the names lack, or the other way
/// round.
fn names_in(rows: &[Vec<String>], columns: usize, is_said: bool) -> (Vec<String>, Vec<String>) {
    let is_name = |row: &Vec<String>| row.len().abs_diff(columns) <= 1 && numbers(row) == 0;
    match rows {
        [.., names, units] if is_name(names) && is_name(units) && names.len() == units.len() => {
            (names.clone(), units.clone())
        }
        [.., names] if is_said || is_name(names) => (names.clone(), Vec::new()),
        _ => (Vec::new(), Vec::new()),
    }
}

impl Beginning {
    fn read(path: &Path) -> Result<Self, InputError> {
        let mut lines = Lines::open(path)?;
        let mut beginning = Self {
            comment: None,
            rows: Vec::new(),
        };
        let mut bytes = 0;
        while beginning.rows.len() < SAMPLE_ROWS && bytes < SAMPLE_BYTES {
            let Some(line) = lines.next()? else { break };
            refuse_pointer(line, path)?;
            bytes += line.len();
            match comment(line) {
                None => beginning.rows.push(line.to_vec()),
                Some(text) if beginning.rows.is_empty() => beginning.comment = Some(text.to_vec()),
                Some(_) => {}
            }
        }
        Ok(beginning)
    }

    /// The separator by which most rows have the same number of cells, more than one.
    fn separator(&self) -> u8 {
        let agreeing = |separator: u8| {
            let mut cells = CellsOfLine::default();
            let counts = self.rows.iter().map(|line| {
                cells.split(line, separator);
                cells.len()
            });
            let counts: Vec<usize> = counts.filter(|count| *count > 1).collect();
            let best = most_frequent(counts.iter().copied());
            counts.iter().filter(|count| Some(**count) == best).count()
        };
        // Of equal ones, the last is the maximum.
        let separators = SEPARATORS.into_iter().rev();
        let best = separators.map(|separator| (agreeing(separator), separator));
        match best.max_by_key(|(agreeing, _)| *agreeing) {
            Some((1.., separator)) => separator,
            _ => b',',
        }
    }

    /// The names in the last comment, if it has as many words as a row has cells. Some write commas above rows of blanks,
    /// or the other way round.
    fn names_in_comment(&self, separator: u8, columns: usize) -> Vec<String> {
        let comment = self.comment.as_deref().unwrap_or_default();
        let splits = [separator, b',', b'\t', b' '];
        let names = splits
            .into_iter()
            .map(|separator| cells(comment, separator));
        let text = text(comment);
        let apart = text
            .split("  ")
            .map(str::trim)
            .filter(|name| !name.is_empty());
        let apart = apart.map(str::to_owned).collect();
        let mut names = names.chain([apart, with_units(&cells(comment, b' '))]);
        names
            .find(|names| names.len() == columns)
            .unwrap_or_default()
    }
}

/// The number that occurs most often; of several, the first.
fn most_frequent(numbers: impl Iterator<Item = usize>) -> Option<usize> {
    let mut counts: Vec<(usize, usize)> = Vec::new();
    for number in numbers {
        match counts.iter_mut().find(|(known, _)| *known == number) {
            Some((_, count)) => *count += 1,
            None => counts.push((number, 1)),
        }
    }
    // Of equal ones, the last is the maximum.
    let most = counts.into_iter().rev().max_by_key(|(_, count)| *count);
    most.map(|(number, _)| number)
}

/// Words with the bracketed units that follow them: `x [m]` is one name.
fn with_units(words: &[String]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for word in words {
        match names.last_mut() {
            Some(name) if word.starts_with(['[', '(']) => *name = format!("{name} {word}"),
            _ => names.push(word.clone()),
        }
    }
    names
}

fn cells(line: &[u8], separator: u8) -> Vec<String> {
    let mut cells = CellsOfLine::default();
    cells.split(line, separator);
    cells.texts()
}

/// How many cells are numbers; a date is one, too.
fn numbers(row: &[String]) -> usize {
    let begins = |cell: &str| cell.starts_with(|c: char| c.is_ascii_digit());
    let is_number = |cell: &&String| {
        let has_digit = cell.contains(|c: char| c.is_ascii_digit());
        let date = || begins(cell) && cell.contains(':');
        has_digit && (cell.replace(',', ".").parse::<f64>().is_ok() || date())
    };
    row.iter().filter(is_number).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> Layout {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        let format = FileFormat::default();
        Sample::read(file.path(), format).unwrap().layout
    }

    #[test]
    fn separators_and_headers_are_recognised() {
        let cases: [(&str, u8, bool, &[&str]); 11] = [
            (
                "# time [s] x [m]\n1 2\n",
                b' ',
                false,
                &["time [s]", "x [m]"],
            ),
            ("# t x y\n1 2 3\n", b' ', false, &["t", "x", "y"]),
            (
                "# a log of mine\n\n1,2,3,4\n",
                b',',
                false,
                &["a", "log", "of", "mine"],
            ),
            ("# my log\nt,x y\n1,2\n", b',', true, &["t", "x y"]),
            ("#t [ns],x [m]\n# \n1,2\n", b',', false, &[]),
            (
                "%time,field.x\r\n1,2\r\n",
                b',',
                false,
                &["time", "field.x"],
            ),
            ("\u{feff}t;x\n0,5;1,25\n", b';', true, &["t", "x"]),
            (
                "2024-01-01 12:00:00,1\n2024-01-01 12:00:01,2\n",
                b',',
                false,
                &[],
            ),
            ("t\tleft wheel\n1\t2\n", b'\t', true, &["t", "left wheel"]),
            ("1   2\t3\n 4 5 6\n", b' ', false, &[]),
            ("", b',', false, &[]),
        ];
        for (text, separator, header_is_row, names) in cases {
            let layout = layout(text);
            let found = (layout.separator, layout.rows_above == 1);
            assert_eq!(found, (separator, header_is_row), "{text}");
            assert_eq!(layout.names, names, "{text}");
        }
        let text = "Version,1.2,of the log\nMade by me\nt,x\n1,2\n3,4\n5,6\n";
        let with_preamble = layout(text);
        assert_eq!(
            (with_preamble.preamble_rows, with_preamble.names),
            (2, vec!["t".to_owned(), "x".to_owned()])
        );
        let of_r = layout("t x\n1 0.5 2\n2 0.6 3\n");
        assert_eq!(of_r.names, ["", "t", "x"]);
        let layout = layout("t,x\ns,mm\n1,2\n");
        assert_eq!(
            (layout.rows_above, layout.units),
            (2, vec!["s".to_owned(), "mm".to_owned()])
        );
    }
}
