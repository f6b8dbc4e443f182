//! Lines of a text file, and their cells.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

/// Longest line that is read (bytes). A message with a covariance has a kilobyte.
const MAX_LINE_BYTES: u64 = 1 << 20;

/// A text file, line by line.
pub(super) struct Lines {
    path: PathBuf,
    source: BufReader<File>,
    bytes: Vec<u8>,
    /// Number of the current line, from 1 on.
    pub(super) number: u64,
    /// Whether the current line has an end; the last one of a log that was cut has none.
    pub(super) is_ended: bool,
}

impl Lines {
    /// Opens a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn open(path: &Path) -> Result<Self, InputError> {
        let file = File::open(path).map_err(|e| InputError::unreadable(path, &e))?;
        Ok(Self {
            path: path.to_owned(),
            source: BufReader::new(file),
            bytes: Vec::new(),
            number: 0,
            is_ended: true,
        })
    }

    /// The next line that is not empty, without its end and without the mark of UTF-8; `None` at the end of the file.
    ///
    /// # Errors
    /// If the file cannot be read, or is not a file of lines.
    pub(super) fn next(&mut self) -> Result<Option<&[u8]>, InputError> {
        loop {
            self.bytes.clear();
            let mut source = (&mut self.source).take(MAX_LINE_BYTES);
            let read = source.read_until(b'\n', &mut self.bytes);
            let read = read.map_err(|e| InputError::unreadable(&self.path, &e))?;
            if read == 0 {
                return Ok(None);
            }
            self.number += 1;
            if read as u64 == MAX_LINE_BYTES {
                let problem = format!("has a line of more than {MAX_LINE_BYTES} bytes");
                let error =
                    InputError::file(&self.path, problem, "give a file of rows, one a line");
                return Err(error.at(self.number));
            }
            if self.bytes.iter().any(|byte| !byte.is_ascii_whitespace()) {
                break;
            }
        }
        self.is_ended = self.bytes.ends_with(b"\n");
        let line = self.bytes.trim_ascii_end();
        Ok(Some(line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line)))
    }
}

/// What a comment line says; `None` for other lines.
pub(super) fn comment(line: &[u8]) -> Option<&[u8]> {
    let line = line.trim_ascii_start();
    let is_mark = |byte: &&u8| matches!(byte, b'#' | b'%' | b'/');
    if !line.starts_with(b"#") && !line.starts_with(b"%") && !line.starts_with(b"//") {
        return None;
    }
    let marks = line.iter().take_while(is_mark).count();
    line.get(marks..).map(<[u8]>::trim_ascii)
}

/// Cells of a line between separators; a blank stands for a run of blanks and tabs. Cells may be quoted.
#[derive(Debug, Default)]
pub(super) struct CellsOfLine {
    /// The cells after each other, without quotes.
    bytes: Vec<u8>,
    /// Where each ends.
    ends: Vec<usize>,
}

impl CellsOfLine {
    /// Splits a line.
    pub(super) fn split(&mut self, line: &[u8], separator: u8) {
        self.bytes.clear();
        self.ends.clear();
        let is_blank = |byte: u8| byte == b' ' || byte == b'\t';
        let in_runs = separator == b' ';
        let line = if in_runs { line.trim_ascii() } else { line };
        let (mut is_quoted, mut start) = (false, 0);
        let mut rest = line.iter().copied().peekable();
        while let Some(byte) = rest.next() {
            let is_end = byte == separator || (in_runs && is_blank(byte));
            if byte == b'"' && is_quoted {
                // Two quotes stand for one.
                is_quoted = rest.next_if_eq(&b'"').is_some();
                if is_quoted {
                    self.bytes.push(byte);
                }
            } else if is_quoted || !(is_end || byte == b'"') {
                self.bytes.push(byte);
            } else if is_end {
                while in_runs && rest.next_if(|byte| is_blank(*byte)).is_some() {}
                self.ends.push(self.bytes.len());
                start = self.bytes.len();
            } else if self
                .bytes
                .get(start..)
                .unwrap_or_default()
                .trim_ascii()
                .is_empty()
            {
                is_quoted = true;
            } else {
                self.bytes.push(byte);
            }
        }
        self.ends.push(self.bytes.len());
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// A cell without blanks around it.
    pub(super) fn get(&self, index: usize) -> Option<&[u8]> {
        let end = *self.ends.get(index)?;
        let before = index
            .checked_sub(1)
            .and_then(|before| self.ends.get(before));
        let cell = self.bytes.get(before.copied().unwrap_or(0)..end)?;
        Some(cell.trim_ascii())
    }

    /// All cells as text.
    pub(super) fn texts(&self) -> Vec<String> {
        let cells = (0..self.len()).filter_map(|index| self.get(index));
        cells.map(text).collect()
    }
}

/// Text in UTF-8, or else in Latin-1, as older programs write `°`.
pub(super) fn text(bytes: &[u8]) -> String {
    let latin = || bytes.iter().map(|byte| char::from(*byte)).collect();
    std::str::from_utf8(bytes).map_or_else(|_| latin(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_split_into_cells() {
        let mut cells = CellsOfLine::default();
        let cases: [(&str, u8, &[&str]); 5] = [
            (r#"1, "a,""b""" ,,3"#, b',', &["1", "a,\"b\"", "", "3"]),
            ("  1 \t 2  3 ", b' ', &["1", "2", "3"]),
            ("a b;c", b';', &["a b", "c"]),
            ("5\" wheel\t2", b'\t', &["5\" wheel", "2"]),
            ("\"open, to the end", b',', &["open, to the end"]),
        ];
        for (line, separator, expected) in cases {
            cells.split(line.as_bytes(), separator);
            assert_eq!(cells.texts(), expected, "{line}");
        }
    }

    #[test]
    fn comments_have_marks() {
        assert_eq!(comment(b" ## a b"), Some(&b"a b"[..]));
        assert_eq!(comment(b"%time,x"), Some(&b"time,x"[..]));
        assert_eq!(comment(b"// x"), Some(&b"x"[..]));
        assert_eq!(comment(b"/odom,1"), None);
        assert_eq!(comment(b"1 # 2"), None);
    }
}
