//! What a map of columns says, as plain data.

use crate::table::StreamKind;

/// What is said of a robot.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RobotEntry {
    pub(super) name: String,
    pub(super) is_pose_of_mass: bool,
    pub(super) encoder_counts_per_rev: Option<f64>,
}

/// A stream and the file that holds it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StreamEntry {
    pub(super) robot: String,
    pub(super) kind: StreamKind,
    /// Name of the file; `None` if the recording is the file.
    pub(super) file: Option<String>,
    pub(super) format: FileFormat,
    pub(super) time: TimeEntry,
    /// Columns of the format with their sources, in the order of the format.
    pub(super) columns: Vec<(&'static str, Source<ColumnEntry>)>,
}

/// What is said of a file's layout; what is not said is recognised.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct FileFormat {
    /// A blank stands for a run of blanks and tabs.
    pub(super) separator: Option<u8>,
    pub(super) has_header: Option<bool>,
}

/// Where the time of a row comes from.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum TimeEntry {
    /// A column with numbers or dates.
    Column(ColumnEntry),
    /// Seconds in one column, nanoseconds in another one.
    Parts([ColumnEntry; 2]),
    /// Rows follow each other by so much (s).
    Period(f64),
    /// A file of this name beside this one has a time (s) in each line, one for each row.
    File(String),
}

/// Where a column of the format comes from. `C` is a column of the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Source<C> {
    /// A column.
    One(C),
    /// Yaw from a quaternion x, y, z, w. A robot in the plane needs no x and y.
    Quaternion([Option<C>; 2], [C; 2]),
    /// Yaw from a vector that points forwards, x and y.
    Direction([C; 2]),
}

/// A column of a file and how to convert its cells.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ColumnEntry {
    pub(super) column: Column,
    pub(super) factor: f64,
    pub(super) offset: f64,
}

/// A column of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Column {
    /// Name in the header.
    Name(String),
    /// Number, from 1 on.
    Number(usize),
}

impl<C> Source<C> {
    /// The same with other columns.
    ///
    /// # Errors
    /// The first that `map` gives.
    pub(super) fn try_map<D, E>(&self, map: impl Fn(&C) -> Result<D, E>) -> Result<Source<D>, E> {
        let pair = |[a, b]: &[C; 2]| Ok([map(a)?, map(b)?]);
        Ok(match self {
            Self::One(column) => Source::One(map(column)?),
            Self::Quaternion([x, y], last) => {
                let first = [x.as_ref().map(&map), y.as_ref().map(&map)];
                let [x, y] = first.map(Option::transpose);
                Source::Quaternion([x?, y?], pair(last)?)
            }
            Self::Direction(both) => Source::Direction(pair(both)?),
        })
    }
}
