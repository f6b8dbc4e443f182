//! Result of reading a recording: the recording, warnings, and what was lost.

use std::collections::BTreeMap;

use crate::bag::Loss;
use crate::recording::Recording;

/// A recording that was read, and what the user should know about the reading.
#[derive(Debug)]
pub struct Import {
    /// The recording.
    pub recording: Recording,
    /// What was ignored, guessed or lost, one entry each.
    pub warnings: Vec<String>,
    /// Parts of an MCAP file that could not be read; `None` for a folder of CSV files.
    pub loss: Option<Loss>,
    /// Number of messages of an MCAP file that [`Recording`] cannot represent, by topic.
    pub left_out: BTreeMap<String, u64>,
}
