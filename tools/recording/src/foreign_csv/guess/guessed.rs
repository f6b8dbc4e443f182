//! A stream that a file seems to have.

use crate::foreign_csv::entry::{ColumnEntry, Source, TimeEntry};
use crate::table::StreamKind;

/// Said of the pose beside a twist.
pub(super) const OF_ODOMETRY: &str = "the pose of an odometry is often the robot's own estimate, not a measurement: \
    then delete the table";
/// Said of wheels of which only one each side is read.
pub(super) const ONE_OF_SEVERAL: &str = "of the wheels on each side, this is the first";

/// A stream that a file seems to have.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Guessed {
    /// Name of the robot, if the file tells it.
    pub(crate) robot: Option<String>,
    pub(crate) kind: StreamKind,
    pub(crate) time: TimeEntry,
    pub(crate) columns: Vec<(&'static str, Source<ColumnEntry>)>,
    /// What a person should know about it.
    pub(crate) note: Option<&'static str>,
}

impl Guessed {
    /// A stream without a note.
    pub(super) fn new(
        kind: StreamKind,
        time: TimeEntry,
        columns: Vec<(&'static str, Source<ColumnEntry>)>,
    ) -> Self {
        Self {
            robot: None,
            kind,
            time,
            columns,
            note: None,
        }
    }

    /// The same with a note.
    pub(super) fn with_note(self, note: &'static str) -> Self {
        Self {
            note: Some(note),
            ..self
        }
    }
}
