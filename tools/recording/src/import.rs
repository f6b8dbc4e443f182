//! Result of reading a recording: the recording, warnings, and what was lost.

use std::collections::BTreeMap;

use slipstream_bag::{Loss, Result};

use crate::recording::{Recording, Robot};
use crate::rows::SpooledRecording;

/// A recording that was read, and what the user should know about the reading.
#[derive(Debug)]
pub struct Import {
    /// The recording.
    pub recording: Recording,
    /// What was guessed, one entry each: the map of topics or columns, and sources that were not used.
    pub guesses: Vec<String>,
    /// What was ignored or lost, and what is odd, one entry each.
    pub warnings: Vec<String>,
    /// What the user should know about the model that came with it; of no interest where another is given.
    pub on_model: Vec<String>,
    /// Parts of an MCAP file that could not be read; `None` for a folder of CSV files.
    pub loss: Option<Loss>,
    /// Number of messages of an MCAP file that [`Recording`] cannot represent, by topic.
    pub left_out: BTreeMap<String, u64>,
}

/// As [`Import`], for recordings of any length: memory holds a thousand rows of each stream, the
/// others are in an unlinked file in the folder for temporary files (`TMPDIR`), which needs about 8
/// bytes for each cell.
///
/// It can be written ([`write_mcap`](Self::write_mcap), [`write_folder`](Self::write_folder)) and
/// checked ([`check`](Self::check)) in that memory.
#[derive(Debug)]
pub struct Spooled {
    /// The recording.
    pub(crate) recording: SpooledRecording,
    /// What was guessed, one entry each: the map of topics or columns, and sources that were not used.
    pub guesses: Vec<String>,
    /// What was ignored or lost, and what is odd, one entry each.
    pub warnings: Vec<String>,
    /// What the user should know about the model that came with it; of no interest where another is given.
    pub on_model: Vec<String>,
    /// Parts of an MCAP file that could not be read; `None` for a folder of CSV files.
    pub loss: Option<Loss>,
    /// Number of messages of an MCAP file that [`Recording`] cannot represent, by topic.
    pub left_out: BTreeMap<String, u64>,
}

impl Spooled {
    /// The robots, without their streams.
    pub fn robots(&self) -> &[Robot] {
        &self.recording.description.robots
    }

    /// The same with the whole recording in memory.
    ///
    /// # Errors
    /// If the temporary file could not be written or read.
    pub fn load(self) -> Result<Import> {
        Ok(Import {
            recording: self.recording.load()?,
            guesses: self.guesses,
            warnings: self.warnings,
            on_model: self.on_model,
            loss: self.loss,
            left_out: self.left_out,
        })
    }
}
