//! What reading a recording gives: the recording, warnings and losses.

use std::collections::BTreeMap;

use crate::bag::Loss;
use crate::recording::Recording;

/// A recording that was read, and what a user should know about how.
#[derive(Debug)]
pub struct Import {
    /// The recording.
    pub recording: Recording,
    /// One line each: what was ignored, guessed or lost.
    pub warnings: Vec<String>,
    /// What of an MCAP file could not be read; `None` for folders.
    pub loss: Option<Loss>,
    /// Messages of an MCAP file that the in-memory form has no place for, by topic.
    pub left_out: BTreeMap<String, u64>,
}
