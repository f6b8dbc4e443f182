//! A file beside another one with the time of each of its rows, one a line, as the sequences of KITTI have it.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

use super::moment::Moment;

/// No time has more bytes.
const MAX_LINE_BYTES: u64 = 4096;

/// The file, and how far it was read.
pub(super) struct TimesFile {
    path: PathBuf,
    source: BufReader<File>,
    line: u64,
}

impl TimesFile {
    /// Opens the file of this name beside another one.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn beside(file: &Path, name: &str) -> Result<Self, InputError> {
        let path = file.with_file_name(name);
        let source = File::open(&path).map_err(|e| InputError::unreadable(&path, &e))?;
        Ok(Self {
            path,
            source: BufReader::new(source),
            line: 0,
        })
    }

    /// The next time; `None` after the last one.
    ///
    /// # Errors
    /// If a line is no number, or the file cannot be read.
    pub(super) fn next(&mut self) -> Result<Option<Moment>, InputError> {
        let mut bytes = Vec::new();
        while bytes.trim_ascii().is_empty() {
            bytes.clear();
            let mut source = (&mut self.source).take(MAX_LINE_BYTES);
            let read = source.read_until(b'\n', &mut bytes);
            if read.map_err(|e| InputError::unreadable(&self.path, &e))? == 0 {
                return Ok(None);
            }
            self.line += 1;
        }
        let text = String::from_utf8_lossy(bytes.trim_ascii()).into_owned();
        let moment = Moment::parse(&text);
        moment.map(Some).ok_or_else(|| {
            let problem = format!("has \"{}\" where a time stands", text.escape_default());
            InputError::file(&self.path, problem, "give one time (s) in each line").at(self.line)
        })
    }
}
