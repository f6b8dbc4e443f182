//! Writer of one stream to an MCAP file: standard messages, and lossless rows where needed.
//!
//! Some rows have no lossless standard message: a yaw does not survive as a quaternion, nor a time
//! finer than a nanosecond, an empty count, or a column that the format does not define. If a stream
//! has such a row, the whole stream is also written as rows ([`MessageType::Row`], topic `…/rows`).
//! Slipstream then reads the rows, and the standard messages are for other programs only.

use std::f64::consts::TAU;
use std::io::Write;

use super::standard::{is_lossless, standard_type, write_standard};
use crate::bag::{BagWriter, Channel};
use crate::error::Result;
use crate::recording::{LinkMessage, Links, Robot, RoundTrips, UnknownColumn};
use crate::ros2::MessageType;
use crate::ros2::compose::joint_state;
use crate::ros2::messages as ros;
use crate::ros2::position::{Fate, PositionRecord};
use crate::ros2::time::{is_whole_ns, ns_from_s};
use crate::table::{
    CellsView, LINK_COLUMNS, LINK_POSE_COLUMNS, ROUND_TRIP_COLUMNS, StreamKind, TableView,
    number_at,
};
use crate::topics::{self, StreamMetadata, robot_topic};

/// A stream with its channels.
pub(super) struct StreamWriter<'a> {
    content: Content<'a>,
    /// Channel of the standard messages.
    standard: Channel,
    /// Channel of the lossless rows, if the standard messages are not lossless.
    lossless: Option<Channel>,
}

enum Content<'a> {
    Robot {
        kind: StreamKind,
        table: TableView<'a>,
        /// For encoder counts with a known number of counts per revolution: channel of the wheel
        /// angles, for viewers, and radians per count.
        joints: Option<(Channel, f64)>,
    },
    Links(&'a Links),
    RoundTrips(&'a RoundTrips),
}

impl<'a> StreamWriter<'a> {
    /// Opens the channels of a robot's stream.
    pub(super) fn of_robot<W: Write>(
        bag: &mut BagWriter<W>,
        robot: &Robot,
        kind: StreamKind,
        table: TableView<'a>,
    ) -> Result<Self> {
        let (message_type, name) = standard_type(kind, &table);
        let metadata = stream_metadata(
            format!("{}/{}", robot.name, kind.name()),
            table.columns.iter().map(|(name, _)| *name),
            table.unknown,
        );
        let topic = robot_topic(&robot.name, name);
        let (standard, lossless) =
            open_channels(bag, &topic, message_type, &metadata, is_lossless(&table))?;
        let counts_per_rev = robot
            .encoder_counts_per_rev
            .filter(|_| name == "encoder_ticks");
        let joints = match counts_per_rev {
            Some(counts) => {
                let topic = robot_topic(&robot.name, "joint_states");
                let view = metadata.to_view_map();
                let channel = bag.channel(&topic, MessageType::JointState, &view)?;
                Some((channel, TAU / f64::from(counts)))
            }
            None => None,
        };
        Ok(Self {
            content: Content::Robot {
                kind,
                table,
                joints,
            },
            standard,
            lossless,
        })
    }

    /// Opens the channels of the position messages.
    pub(super) fn of_links<W: Write>(bag: &mut BagWriter<W>, links: &'a Links) -> Result<Self> {
        let columns = if links.with_velocity {
            LINK_COLUMNS.len()
        } else {
            LINK_POSE_COLUMNS
        };
        let columns = LINK_COLUMNS.into_iter().take(columns).skip(1);
        let metadata = stream_metadata(topics::LINK_STREAM.to_owned(), columns, &links.unknown);
        let is_lossless = links.unknown.is_empty()
            && links.messages.iter().all(|message| {
                is_whole_ns(message.t_sent_s) && message.t_received_s.is_none_or(is_whole_ns)
            });
        let kind = MessageType::PositionMessage;
        let (standard, lossless) = open_channels(bag, topics::LINKS, kind, &metadata, is_lossless)?;
        Ok(Self {
            content: Content::Links(links),
            standard,
            lossless,
        })
    }

    /// Opens the channels of the round trips.
    pub(super) fn of_round_trips<W: Write>(
        bag: &mut BagWriter<W>,
        trips: &'a RoundTrips,
    ) -> Result<Self> {
        let metadata = stream_metadata(
            topics::ROUND_TRIP_STREAM.to_owned(),
            ROUND_TRIP_COLUMNS.into_iter(),
            &trips.unknown,
        );
        let is_lossless = trips.unknown.is_empty();
        let kind = MessageType::RoundTrip;
        let (standard, lossless) =
            open_channels(bag, topics::ROUND_TRIPS, kind, &metadata, is_lossless)?;
        Ok(Self {
            content: Content::RoundTrips(trips),
            standard,
            lossless,
        })
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        match &self.content {
            Content::Robot { table, .. } => table.t_s.len(),
            Content::Links(links) => links.messages.len(),
            Content::RoundTrips(trips) => trips.seq.len(),
        }
    }

    /// Time of a row (ns). Round trips have no time; the row's index is used instead.
    pub(super) fn t_ns(&self, row: usize) -> i64 {
        match &self.content {
            Content::Robot { table, .. } => ns_from_s(number_at(table.t_s, row)),
            Content::Links(links) => ns_from_s(links.messages.get(row).map_or(0.0, |m| m.t_sent_s)),
            Content::RoundTrips(_) => i64::try_from(row).unwrap_or(i64::MAX),
        }
    }

    /// Writes a row to its channels.
    pub(super) fn write<W: Write>(
        &self,
        bag: &mut BagWriter<W>,
        t_ns: i64,
        row: usize,
    ) -> Result<()> {
        match &self.content {
            Content::Robot {
                kind,
                table,
                joints,
            } => {
                write_standard(bag, self.standard, *kind, table, t_ns, row)?;
                if let Some((channel, rad_per_count)) = joints {
                    let angle = |i| table.number(i, row) * rad_per_count;
                    let angles = [angle(0), angle(1)];
                    bag.write(*channel, t_ns, &joint_state(t_ns, &angles, &[], &[]))?;
                }
                self.write_lossless(bag, t_ns, || robot_row(table, row))
            }
            Content::Links(links) => {
                let Some(message) = links.messages.get(row) else {
                    return Ok(());
                };
                bag.write(
                    self.standard,
                    t_ns,
                    &position_record(message, t_ns, row).message(),
                )?;
                self.write_lossless(bag, t_ns, || link_row(message, &links.unknown, row))
            }
            Content::RoundTrips(trips) => {
                let seq = trips.seq.get(row).copied().unwrap_or_default();
                let rtt_ms = number_at(&trips.rtt_ms, row);
                bag.write(self.standard, t_ns, &ros::RoundTrip { seq, rtt_ms })?;
                self.write_lossless(bag, t_ns, || {
                    let mut texts = vec![seq.to_string()];
                    texts.extend(unknown_cells(&trips.unknown, row));
                    lossless_row(0.0, vec![rtt_ms], texts)
                })
            }
        }
    }

    fn write_lossless<W: Write>(
        &self,
        bag: &mut BagWriter<W>,
        t_ns: i64,
        row: impl FnOnce() -> LosslessRow,
    ) -> Result<()> {
        match self.lossless {
            Some(channel) => bag.write(channel, t_ns, &row()),
            None => Ok(()),
        }
    }
}

/// Opens the channel of the standard messages and, if these are not lossless, that of the rows. The
/// metadata of one of the two says that slipstream reads the stream from it.
fn open_channels<W: Write>(
    bag: &mut BagWriter<W>,
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

/// A recorded position message; the row's index stands for its sequence number.
fn position_record(message: &LinkMessage, t_ns: i64, row: usize) -> PositionRecord<'_> {
    PositionRecord {
        sender: &message.from,
        receiver: &message.to,
        seq: row as u64,
        t_sampled_ns: t_ns,
        t_sent_ns: t_ns,
        fate: match message.t_received_s {
            Some(t_s) => Fate::Arrived {
                t_received_ns: ns_from_s(t_s),
            },
            None => Fate::Lost,
        },
        pose: [message.x_m, message.y_m, message.yaw_rad],
        velocity: Some([message.v_m_s, message.w_rad_s]),
    }
}

type LosslessRow = ros::Row<Vec<f64>, Vec<String>>;

fn lossless_row(t_s: f64, numbers: Vec<f64>, texts: Vec<String>) -> LosslessRow {
    ros::Row {
        t_s,
        numbers,
        texts,
    }
}

/// A row of a robot's stream: numbers in the order of their columns, and as text the counts and the
/// unknown columns.
fn robot_row(table: &TableView<'_>, row: usize) -> LosslessRow {
    let mut numbers = Vec::with_capacity(table.columns.len());
    let mut texts = Vec::new();
    for (_, cells) in &table.columns {
        match cells {
            CellsView::Numbers(cells) => numbers.push(number_at(cells, row)),
            CellsView::Counts(cells) => {
                let count = cells.get(row).copied().flatten();
                texts.push(count.map_or_else(String::new, |count| count.to_string()));
            }
        }
    }
    texts.extend(unknown_cells(table.unknown, row));
    lossless_row(number_at(table.t_s, row), numbers, texts)
}

fn link_row(message: &LinkMessage, unknown: &[UnknownColumn], row: usize) -> LosslessRow {
    let mut texts = vec![message.from.to_string(), message.to.to_string()];
    texts.extend(unknown_cells(unknown, row));
    let numbers = vec![
        message.t_received_s.unwrap_or(f64::NAN),
        message.x_m,
        message.y_m,
        message.yaw_rad,
        message.v_m_s,
        message.w_rad_s,
    ];
    lossless_row(message.t_sent_s, numbers, texts)
}

fn unknown_cells(unknown: &[UnknownColumn], row: usize) -> impl Iterator<Item = String> {
    unknown
        .iter()
        .map(move |column| column.cells.get(row).cloned().unwrap_or_default())
}
