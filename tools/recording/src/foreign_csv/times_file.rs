//! A file beside another one with the time of each of its rows, one a line, as the sequences of KITTI have it.

use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

use super::lines::Lines;
use super::moment::Moment;

/// No time has more bytes.
const MAX_TIME_BYTES: usize = 4096;

/// The file, and how far it was read.
pub(super) struct TimesFile {
    path: PathBuf,
    lines: Lines,
}

impl TimesFile {
    /// Opens the file of this name beside another one.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn beside(file: &Path, name: &str) -> Result<Self, InputError> {
        let path = file.with_file_name(name);
        let lines = Lines::open(&path)?;
        Ok(Self { path, lines })
    }

    /// The next time; `None` after the last one.
    ///
    /// # Errors
    /// If a line is no number, or the file cannot be read.
    pub(super) fn next(&mut self) -> Result<Option<Moment>, InputError> {
        let Some(line) = self.lines.next()? else {
            return Ok(None);
        };
        let time = line.get(..MAX_TIME_BYTES).unwrap_or(line).trim_ascii();
        let text = String::from_utf8_lossy(time).into_owned();
        let moment = Moment::parse(&text);
        moment.map(Some).ok_or_else(|| {
            let problem = format!("has \"{}\" where a time stands", text.escape_default());
            let remedy = "give one time (s) in each line";
            InputError::file(&self.path, problem, remedy).at(self.lines.number)
        })
    }
}
