//! Writer of one stream to an MCAP file: standard messages, and lossless rows where needed.
//!
//! Some rows have no lossless standard message: a yaw does not survive as a quaternion, nor a time
//! finer than a nanosecond, an empty count, or a column that the format does not define. If a stream
//! has such a row, the whole stream is also written as rows ([`MessageType::Row`], topic `…/rows`).
//! Slipstream then reads the rows, and the standard messages are for other programs only.

use std::f64::consts::TAU;

use slipstream_bag::ros::MessageType;
use slipstream_bag::ros::compose::joint_state;
use slipstream_bag::ros::messages as ros;
use slipstream_bag::ros::time::{is_whole_ns, ns_from_s};
use slipstream_bag::{BagWriter, Channel, Result};

use super::standard::{first_column, is_lossless, write_standard};
use crate::position::{Fate, PositionRecord};
use crate::recording::{Robot, UnknownColumn};
use crate::rows::{LinkRows, RowCursor, Rows};
use crate::table::{
    Cells, LINK_COLUMNS, ROUND_TRIP_COLUMNS, StreamKind, Table, link_columns, number_at,
};
use crate::topics::{self, StreamMetadata, robot_topic, standard_type};

/// A stream with its channels, and the next of its rows.
pub(super) struct StreamWriter<'a> {
    content: Content,
    rows: RowCursor<'a>,
    /// Number of rows written so far.
    written: usize,
    /// Channel of the standard messages.
    standard: Channel,
    /// Channel of the lossless rows, if the standard messages are not lossless.
    lossless: Option<Channel>,
}

enum Content {
    Robot {
        kind: StreamKind,
        /// For encoder counts with a known number of counts per revolution: channel of the wheel
        /// angles, for viewers, and radians per count.
        joints: Option<(Channel, f64)>,
    },
    Links,
    RoundTrips,
}

impl<'a> StreamWriter<'a> {
    /// Opens the channels of a robot's stream.
    pub(super) fn of_robot(
        bag: &mut BagWriter<'_>,
        robot: &Robot,
        kind: StreamKind,
        rows: &Rows<'a>,
    ) -> Result<Self> {
        let empty = rows.empty();
        let (message_type, name) = standard_type(kind, first_column(empty));
        let metadata = stream_metadata(
            format!("{}/{}", robot.name, kind.name()),
            empty.columns.iter().map(|(name, _)| *name),
            &empty.unknown,
        );
        let topic = robot_topic(&robot.name, name);
        let is_lossless = empty.unknown.is_empty() && all_blocks(rows, is_lossless);
        let (standard, lossless) =
            open_channels(bag, &topic, message_type, &metadata, is_lossless)?;
        let counts_per_rev = robot
            .encoder_counts_per_rev
            .filter(|_| name == "encoder_ticks");
        let joints = match counts_per_rev {
            Some(counts) => {
                let topic = robot_topic(&robot.name, "joint_states");
                let view = metadata.to_view_map();
                let channel = bag.channel(&topic, MessageType::JointState, &view)?;
                Some((channel, TAU / counts))
            }
            None => None,
        };
        let content = Content::Robot { kind, joints };
        Ok(Self::new(content, rows, (standard, lossless)))
    }

    /// Opens the channels of the position messages.
    pub(super) fn of_links(bag: &mut BagWriter<'_>, links: &LinkRows<'a>) -> Result<Self> {
        let unknown = &links.rows.empty().unknown;
        let columns = LINK_COLUMNS.into_iter();
        let columns = columns.take(link_columns(links.with_velocity)).skip(1);
        let metadata = stream_metadata(topics::LINK_STREAM.to_owned(), columns, unknown);
        let whole_ns = |table: &Table| {
            let received = table.numbers_of("t_received_s").iter();
            table.t_s.iter().all(|t_s| is_whole_ns(*t_s))
                && received
                    .copied()
                    .all(|t_s| t_s.is_nan() || is_whole_ns(t_s))
        };
        let is_lossless = unknown.is_empty() && all_blocks(&links.rows, whole_ns);
        let kind = MessageType::PositionMessage;
        let channels = open_channels(bag, topics::LINKS, kind, &metadata, is_lossless)?;
        Ok(Self::new(Content::Links, &links.rows, channels))
    }

    /// Opens the channels of the round trips.
    pub(super) fn of_round_trips(bag: &mut BagWriter<'_>, rows: &Rows<'a>) -> Result<Self> {
        let unknown = &rows.empty().unknown;
        let columns = ROUND_TRIP_COLUMNS.into_iter();
        let metadata = stream_metadata(topics::ROUND_TRIP_STREAM.to_owned(), columns, unknown);
        let kind = MessageType::RoundTrip;
        let channels = open_channels(
            bag,
            topics::ROUND_TRIPS,
            kind,
            &metadata,
            unknown.is_empty(),
        )?;
        Ok(Self::new(Content::RoundTrips, rows, channels))
    }

    fn new(content: Content, rows: &Rows<'a>, channels: (Channel, Option<Channel>)) -> Self {
        Self {
            content,
            rows: rows.clone().row_cursor(),
            written: 0,
            standard: channels.0,
            lossless: channels.1,
        }
    }

    /// Time of the next row (ns); `None` after the last one. Round trips have no time; the row's
    /// index is used instead.
    pub(super) fn t_ns(&self) -> Option<i64> {
        let (table, row) = self.rows.row()?;
        match self.content {
            Content::Robot { .. } | Content::Links => Some(ns_from_s(number_at(&table.t_s, row))),
            Content::RoundTrips => Some(i64::try_from(self.written).unwrap_or(i64::MAX)),
        }
    }

    /// Writes the next row to its channels.
    pub(super) fn write_next(&mut self, bag: &mut BagWriter<'_>) -> Result<()> {
        let (Some(t_ns), Some((table, row))) = (self.t_ns(), self.rows.row()) else {
            return Ok(());
        };
        match &self.content {
            Content::Robot { kind, joints } => {
                write_standard(bag, self.standard, *kind, table, t_ns, row)?;
                if let Some((channel, rad_per_count)) = joints {
                    let angle = |i| table.number(i, row) * rad_per_count;
                    let angles = [angle(0), angle(1)];
                    bag.write(*channel, t_ns, &joint_state(t_ns, &angles, &[], &[]))?;
                }
            }
            Content::Links => {
                let message = position_record(table, t_ns, row, self.written);
                bag.write(self.standard, t_ns, &message.message())?;
            }
            Content::RoundTrips => {
                let trip = ros::RoundTrip {
                    seq: table.count(0, row).unwrap_or_default(),
                    rtt_ms: table.number(1, row),
                };
                bag.write(self.standard, t_ns, &trip)?;
            }
        }
        if let Some(channel) = self.lossless {
            bag.write(channel, t_ns, &lossless_row(table, row))?;
        }
        self.rows.advance();
        self.written += 1;
        Ok(())
    }
}

/// Whether `holds` of all blocks of a stream.
fn all_blocks(rows: &Rows<'_>, holds: impl Fn(&Table) -> bool) -> bool {
    let mut cursor = rows.clone().cursor();
    while let Some(block) = cursor.next_block() {
        if !holds(block) {
            return false;
        }
    }
    true
}

/// Opens the channel of the standard messages and, if these are not lossless, that of the rows. The
/// metadata of one of the two says that slipstream reads the stream from it.
fn open_channels(
    bag: &mut BagWriter<'_>,
    topic: &str,
    message_type: MessageType,
    metadata: &StreamMetadata,
    is_lossless: bool,
) -> Result<(Channel, Option<Channel>)> {
    if is_lossless {
        let standard = bag.channel(topic, message_type, &metadata.to_map())?;
        return Ok((standard, None));
    }
    let standard = bag.channel(topic, message_type, &metadata.to_view_map())?;
    let topic = format!("{topic}/rows");
    let rows = bag.channel(&topic, MessageType::Row, &metadata.to_map())?;
    Ok((standard, Some(rows)))
}

fn stream_metadata<'a>(
    stream: String,
    columns: impl Iterator<Item = &'a str>,
    unknown: &[UnknownColumn],
) -> StreamMetadata {
    StreamMetadata {
        stream,
        columns: columns.map(str::to_owned).collect(),
        unknown: unknown.iter().map(|column| column.name.clone()).collect(),
    }
}

/// A recorded position message; the row's index in the stream stands for its sequence number.
fn position_record(table: &Table, t_ns: i64, row: usize, index: usize) -> PositionRecord<'_> {
    let number = |name| table.number_named(name, row);
    let received_s = number("t_received_s");
    PositionRecord {
        sender: table.text_named("from", row),
        receiver: table.text_named("to", row),
        seq: index as u64,
        t_sampled_ns: t_ns,
        t_sent_ns: t_ns,
        fate: if received_s.is_nan() {
            Fate::Lost
        } else {
            Fate::Arrived {
                t_received_ns: ns_from_s(received_s),
            }
        },
        pose: ["x_m", "y_m", "yaw_rad"].map(number),
        velocity: Some(["v_m_s", "w_rad_s"].map(number)),
        extra: &[],
    }
}

/// A row without loss: numbers in the order of their columns, and as text the counts, the names and
/// the unknown columns.
fn lossless_row(table: &Table, row: usize) -> ros::Row<Vec<f64>, Vec<String>> {
    let mut numbers = Vec::with_capacity(table.columns.len());
    let mut texts = Vec::new();
    for (_, cells) in &table.columns {
        match cells {
            Cells::Numbers(cells) => numbers.push(number_at(cells, row)),
            Cells::Counts(cells) => {
                let count = cells.get(row).copied().flatten();
                texts.push(count.map_or_else(String::new, |count| count.to_string()));
            }
            Cells::Texts(cells) => texts.push(cells.get(row).cloned().unwrap_or_default()),
        }
    }
    let unknown = table.unknown.iter().map(|column| column.cells.get(row));
    texts.extend(unknown.map(|cell| cell.cloned().unwrap_or_default()));
    ros::Row {
        t_s: number_at(&table.t_s, row),
        numbers,
        texts,
    }
}
