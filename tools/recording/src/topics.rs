//! The topics of our files, and what their channels' metadata say.

use std::collections::BTreeMap;

use crate::table::StreamKind;

/// Name of the metadata record that says what the file is.
pub(crate) const ABOUT: &str = "slipstream";
/// Name of the attached description.
pub(crate) const DESCRIPTION: &str = "recording.toml";
/// Name of the attached nominal model.
pub(crate) const MODEL: &str = "robot.toml";
/// Topic of the messages between robots.
pub(crate) const LINKS: &str = "/links";
/// Topic of measured round trips.
pub(crate) const RTT: &str = "/rtt";
/// Topic of the steps of positions' ways.
pub(crate) const TRACE: &str = "/trace";
/// Topic of true poses, for viewers.
pub(crate) const TF: &str = "/tf";

/// Metadata key: the stream that slipstream reads from this channel, such as `r1/pose`.
const STREAM: &str = "stream";
/// Metadata key: the stream's columns as in the head of its CSV file, without the time.
const COLUMNS: &str = "columns";
/// Metadata key: columns that the format does not know, one a line.
const UNKNOWN: &str = "unknown_columns";

/// Metadata key: the stream that this channel shows to other programs; slipstream reads it
/// elsewhere.
const VIEW: &str = "view_of";

/// What a channel carries for slipstream. A channel without it is for other programs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Carries {
    /// `ROBOT/KIND`, `links` or `rtt`.
    pub(crate) stream: String,
    /// Known columns.
    pub(crate) columns: Vec<String>,
    /// Unknown columns.
    pub(crate) unknown: Vec<String>,
}

impl Carries {
    /// The stream of a robot with these columns, joined by commas.
    pub(crate) fn robot(robot: &str, kind: StreamKind, columns: &str) -> Self {
        Self {
            stream: format!("{robot}/{}", kind.name()),
            columns: columns.split(',').map(str::to_owned).collect(),
            unknown: Vec::new(),
        }
    }

    /// As a channel's metadata.
    pub(crate) fn metadata(&self) -> BTreeMap<String, String> {
        let mut metadata = BTreeMap::from([
            (STREAM.to_owned(), self.stream.clone()),
            (COLUMNS.to_owned(), self.columns.join(",")),
        ]);
        if !self.unknown.is_empty() {
            metadata.insert(UNKNOWN.to_owned(), self.unknown.join("\n"));
        }
        metadata
    }

    /// The metadata of a channel that only shows the same stream to other programs.
    pub(crate) fn view_metadata(&self) -> BTreeMap<String, String> {
        BTreeMap::from([(VIEW.to_owned(), self.stream.clone())])
    }

    /// From a channel's metadata, if it carries anything.
    pub(crate) fn from_metadata(metadata: &BTreeMap<String, String>) -> Option<Self> {
        let list = |key: &str, separator: char| -> Vec<String> {
            metadata
                .get(key)
                .filter(|list| !list.is_empty())
                .map(|list| list.split(separator).map(str::to_owned).collect())
                .unwrap_or_default()
        };
        Some(Self {
            stream: metadata.get(STREAM)?.clone(),
            columns: list(COLUMNS, ','),
            unknown: list(UNKNOWN, '\n'),
        })
    }
}

/// Whether a channel only shows what another one carries.
pub(crate) fn is_view(metadata: &BTreeMap<String, String>) -> bool {
    metadata.contains_key(VIEW)
}

/// The topic of a robot's stream: `/r1/pose`.
pub(crate) fn topic(robot: &str, name: &str) -> String {
    format!("/{robot}/{name}")
}
