//! Layout of a text file, recognised from its first rows: separator, header, names of the columns.

use std::path::Path;

use slipstream_bus::InputError;

use super::entry::FileFormat;
use super::lines::{CellsOfLine, Lines, comment};

/// So many rows tell the layout.
const SAMPLE_ROWS: usize = 60;
/// Separators, the first of several that fit alike is taken; a blank stands for a run of blanks and tabs.
const SEPARATORS: [u8; 4] = [b'\t', b';', b',', b' '];

/// How a file is laid out.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    pub(super) separator: u8,
    /// Whether the first row has the names.
    pub(super) header_is_row: bool,
    /// The names of the columns, from the first row or the last comment before it; empty if there are none.
    pub(super) names: Vec<String>,
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
        let mut rows = beginning.rows.iter().map(|line| cells(line, separator));
        let first = rows.next().unwrap_or_default();
        let in_comment = || beginning.names_in_comment(separator, first.len());
        let (names, header_is_row) = match said.has_header {
            Some(false) => (Vec::new(), false),
            None if has_number(&first) => (in_comment(), false),
            None => (first.clone(), true),
            Some(true) => match in_comment() {
                names if names.is_empty() || !has_number(&first) => (first.clone(), true),
                names => (names, false),
            },
        };
        let mut rows: Vec<Vec<String>> = rows.collect();
        if !header_is_row {
            rows.insert(0, first);
        }
        Ok(Self {
            layout: Layout {
                separator,
                header_is_row,
                names,
            },
            rows,
        })
    }
}

impl Beginning {
    fn read(path: &Path) -> Result<Self, InputError> {
        let mut lines = Lines::open(path)?;
        let mut beginning = Self {
            comment: None,
            rows: Vec::new(),
        };
        while beginning.rows.len() < SAMPLE_ROWS {
            let Some(line) = lines.next()? else { break };
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
            let counts = self.rows.iter().map(|line| cells(line, separator).len());
            let counts: Vec<usize> = counts.filter(|count| *count > 1).collect();
            let same = |count: &usize| counts.iter().filter(|other| *other == count).count();
            counts.iter().map(same).max().unwrap_or(0)
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
        let splits = [separator, b',', b' '];
        let mut names = splits
            .into_iter()
            .map(|separator| cells(comment, separator));
        names
            .find(|names| names.len() == columns)
            .unwrap_or_default()
    }
}

fn cells(line: &[u8], separator: u8) -> Vec<String> {
    let mut cells = CellsOfLine::default();
    cells.split(line, separator);
    cells.texts()
}

/// Whether a row has a number; a date is one, too.
fn has_number(row: &[String]) -> bool {
    let begins = |cell: &String| cell.starts_with(|c: char| c.is_ascii_digit());
    let is_number = |cell: &String| {
        let has_digit = cell.contains(|c: char| c.is_ascii_digit());
        let date = || begins(cell) && cell.contains(':');
        has_digit && (cell.replace(',', ".").parse::<f64>().is_ok() || date())
    };
    row.iter().any(is_number)
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
        let cases: [(&str, u8, bool, &[&str]); 10] = [
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
            ("", b',', true, &[]),
        ];
        for (text, separator, header_is_row, names) in cases {
            let layout = layout(text);
            let found = (layout.separator, layout.header_is_row);
            assert_eq!(found, (separator, header_is_row), "{text}");
            assert_eq!(layout.names, names, "{text}");
        }
    }
}
