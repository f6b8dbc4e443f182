//! A stream that a file seems to have.

use crate::foreign_csv::entry::{Column, ColumnEntry, Source, TimeEntry};
use crate::foreign_csv::layout::Sample;
use crate::table::StreamKind;

/// Said of the pose beside a twist.
pub(super) const OF_ODOMETRY: &str = "the pose of an odometry message is often the robot's own estimate, not a measurement: \
    then delete the table";

/// A stream that a file seems to have.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Guessed {
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

/// A column by its name, or by its number if it has none.
pub(super) fn entry(sample: &Sample, index: usize, factor: f64) -> ColumnEntry {
    let column = match sample.layout.names.get(index) {
        Some(name) if !name.is_empty() => Column::Name(name.clone()),
        _ => Column::Number(index + 1),
    };
    ColumnEntry {
        column,
        factor,
        offset: 0.0,
    }
}
