//! Topics and channel metadata of the MCAP files that slipstream writes.

use std::collections::BTreeMap;

use slipstream_bag::ros::MessageType;

use crate::table::StreamKind;

/// Name of the metadata record that identifies a file written by slipstream.
pub(crate) const FILE_METADATA: &str = "slipstream";
/// Name of the attached description of the recording.
pub(crate) const DESCRIPTION: &str = "recording.toml";
/// Name of the attached nominal model.
pub(crate) const MODEL: &str = "robot.toml";
/// Topic of the position messages between robots.
pub(crate) const LINKS: &str = "/links";
/// Topic of measured round trips.
pub(crate) const ROUND_TRIPS: &str = "/rtt";
/// Topic of trace records.
pub(crate) const TRACE: &str = "/trace";
/// Topic of events in words.
pub(crate) const EVENTS: &str = "/events";
/// Topic of true poses, for viewers.
pub(crate) const TF: &str = "/tf";

/// Name of the stream of position messages in channel metadata.
pub(crate) const LINK_STREAM: &str = "links";
/// Name of the stream of round trips in channel metadata.
pub(crate) const ROUND_TRIP_STREAM: &str = "rtt";

/// Metadata key: the stream that slipstream reads from this channel, such as `r1/pose`.
const STREAM_KEY: &str = "stream";
/// Metadata key: the columns of the stream, as in the header of its CSV file without the time.
const COLUMNS_KEY: &str = "columns";
/// Metadata key: columns that the format does not define, one per line.
const UNKNOWN_KEY: &str = "unknown_columns";
/// Metadata key: the stream that this channel shows to other programs. Slipstream reads the stream
/// from another channel.
const VIEW_KEY: &str = "view_of";

/// The stream that slipstream reads from a channel. Channels without it are for other programs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct StreamMetadata {
    /// `ROBOT/KIND`, [`LINK_STREAM`] or [`ROUND_TRIP_STREAM`].
    pub(crate) stream: String,
    /// Columns that the format defines.
    pub(crate) columns: Vec<String>,
    /// Columns that the format does not define.
    pub(crate) unknown: Vec<String>,
}

impl StreamMetadata {
    /// A robot's stream with these columns, separated by commas.
    pub(crate) fn of_robot(robot: &str, kind: StreamKind, columns: &str) -> Self {
        Self {
            stream: format!("{robot}/{}", kind.name()),
            columns: columns.split(',').map(str::to_owned).collect(),
            unknown: Vec::new(),
        }
    }

    /// The channel metadata of the channel that holds this stream.
    pub(crate) fn to_map(&self) -> BTreeMap<String, String> {
        let mut metadata = BTreeMap::from([
            (STREAM_KEY.to_owned(), self.stream.clone()),
            (COLUMNS_KEY.to_owned(), self.columns.join(",")),
        ]);
        if !self.unknown.is_empty() {
            let names: Vec<String> = self.unknown.iter().map(|name| escaped(name)).collect();
            metadata.insert(UNKNOWN_KEY.to_owned(), names.join("\n"));
        }
        metadata
    }

    /// The channel metadata of a channel that only shows this stream to other programs.
    pub(crate) fn to_view_map(&self) -> BTreeMap<String, String> {
        BTreeMap::from([(VIEW_KEY.to_owned(), self.stream.clone())])
    }

    /// Reads channel metadata; `None` if the channel holds no stream.
    pub(crate) fn from_map(metadata: &BTreeMap<String, String>) -> Option<Self> {
        let columns = metadata.get(COLUMNS_KEY).filter(|list| !list.is_empty());
        // A column without a name is a column, too.
        let unknown = metadata.get(UNKNOWN_KEY);
        Some(Self {
            stream: metadata.get(STREAM_KEY)?.clone(),
            columns: columns.map_or_else(Vec::new, |list| {
                list.split(',').map(str::to_owned).collect()
            }),
            unknown: unknown
                .map_or_else(Vec::new, |list| list.split('\n').map(unescaped).collect()),
        })
    }
}

/// A column's name without line breaks.
fn escaped(name: &str) -> String {
    name.replace('\\', "\\\\").replace('\n', "\\n")
}

fn unescaped(line: &str) -> String {
    let mut name = String::with_capacity(line.len());
    let mut characters = line.chars();
    while let Some(character) = characters.next() {
        name.push(match character {
            '\\' => match characters.next() {
                Some('n') => '\n',
                other => other.unwrap_or('\\'),
            },
            other => other,
        });
    }
    name
}

/// Whether a channel only shows a stream that another channel holds.
pub(crate) fn is_view(metadata: &BTreeMap<String, String>) -> bool {
    metadata.contains_key(VIEW_KEY)
}

/// The standard message type of a stream whose first column is this, and the last part of its topic.
pub(crate) fn standard_type(kind: StreamKind, first_column: &str) -> (MessageType, &'static str) {
    match (kind, first_column) {
        (StreamKind::Command, "voltage_right_v") => (MessageType::WheelVoltage, "command"),
        (StreamKind::Command, "v_m_s") => (MessageType::TwistStamped, "command"),
        (StreamKind::Command, _) => (MessageType::JointState, "command"),
        (StreamKind::Wheels, "ticks_right") => (MessageType::EncoderTicks, "encoder_ticks"),
        (StreamKind::Wheels, _) => (MessageType::JointState, "joint_states"),
        (StreamKind::Odometry, _) => (MessageType::TwistStamped, "odometry"),
        (StreamKind::Pose, _) => (MessageType::PoseStamped, "pose"),
        (StreamKind::Imu, _) => (MessageType::Imu, "imu"),
        (StreamKind::Motor, _) => (MessageType::MotorState, "motor"),
    }
}

/// The topic of a robot's stream, such as `/r1/pose`.
pub(crate) fn robot_topic(robot: &str, name: &str) -> String {
    format!("/{robot}/{name}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_columns_keep_their_names_whatever_these_are() {
        for unknown in [vec![], vec![""], vec!["", ""], vec!["a\nb", "\\n", "c\\"]] {
            let metadata = StreamMetadata {
                unknown: unknown.into_iter().map(str::to_owned).collect(),
                ..StreamMetadata::of_robot("r1", StreamKind::Pose, "x_m,y_m")
            };
            assert_eq!(StreamMetadata::from_map(&metadata.to_map()), Some(metadata));
        }
    }
}
