//! A recording as an MCAP file: standard messages for other programs, and every row to the digit.
//!
//! Where a standard message cannot give a row back bit for bit (a yaw in a quaternion, a time finer
//! than a nanosecond, an empty count, a column that the format does not know), the whole stream is
//! written a second time as rows ([`MessageType::Row`], topic `…/rows`). Then the rows are what
//! slipstream reads, and the standard messages are for other programs only.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::f64::consts::TAU;
use std::io::Write;
use std::path::Path;

use super::standard::{at, cell, holds, standard, write_standard};
use crate::bag::{BagWriter, Channel};
use crate::error::Result;
use crate::recording::{Links, Recording, Robot, RoundTrips, UnknownColumn};
use crate::ros2::MessageType;
use crate::ros2::compose::joint_state;
use crate::ros2::messages as ros;
use crate::ros2::position::{Fate, PositionRecord, position_message};
use crate::ros2::time::{is_whole_ns, ns_from_s};
use crate::table::{CellsView, LINK_COLUMNS, StreamKind, TableView};
use crate::toml_files::{recording_toml, robot_toml};
use crate::topics::{self, Carries, topic};

/// Writes the recording to an MCAP file, replacing what was there.
///
/// # Errors
/// When the system does not let it be written.
pub fn write_mcap(recording: &Recording, path: &Path) -> Result<()> {
    write(recording, BagWriter::create(path)?).map(|_| ())
}

/// Writes the recording as MCAP to `sink`; `path` is only for errors.
///
/// # Errors
/// When `sink` fails.
pub fn write_mcap_to<W: Write>(recording: &Recording, sink: W, path: &Path) -> Result<W> {
    write(recording, BagWriter::new(sink, path)?)
}

fn write<W: Write>(recording: &Recording, mut bag: BagWriter<W>) -> Result<W> {
    let toml = "application/toml";
    let description = recording_toml::to_text(recording);
    bag.attach(topics::DESCRIPTION, toml, description.as_bytes())?;
    if let Some(model) = &recording.model {
        bag.attach(topics::MODEL, toml, robot_toml::to_text(model).as_bytes())?;
    }
    let about = [
        ("format", "1"),
        ("kind", "recording"),
        ("version", env!("CARGO_PKG_VERSION")),
    ];
    let about = about.map(|(key, value)| (key.to_owned(), value.to_owned()));
    bag.metadata(topics::ABOUT, BTreeMap::from(about))?;

    let mut sources = Vec::new();
    for robot in &recording.robots {
        for kind in StreamKind::ALL {
            if let Some(table) = TableView::of(robot, kind) {
                sources.push(Source::stream(&mut bag, robot, kind, table)?);
            }
        }
    }
    if let Some(links) = &recording.links {
        sources.push(Source::links(&mut bag, links)?);
    }
    if let Some(rtt) = &recording.rtt {
        sources.push(Source::round_trips(&mut bag, rtt)?);
    }
    write_in_time_order(&mut bag, &sources)?;
    bag.finish()
}

/// Writes the rows of all sources by their time; at the same time in the order of the sources.
fn write_in_time_order<W: Write>(bag: &mut BagWriter<W>, sources: &[Source<'_>]) -> Result<()> {
    let mut next: BinaryHeap<Reverse<(i64, usize, usize)>> = BinaryHeap::new();
    for (at, source) in sources.iter().enumerate() {
        if source.rows() > 0 {
            next.push(Reverse((source.t_ns(0), at, 0)));
        }
    }
    while let Some(Reverse((t_ns, at, row))) = next.pop() {
        let Some(source) = sources.get(at) else {
            continue;
        };
        source.write(bag, t_ns, row)?;
        if row + 1 < source.rows() {
            next.push(Reverse((source.t_ns(row + 1), at, row + 1)));
        }
    }
    Ok(())
}

/// One stream on its way into the file.
struct Source<'a> {
    rows_of: Rows<'a>,
    /// The standard messages.
    standard: Channel,
    /// The stream once more to the digit, where the standard messages do not hold it.
    exact: Option<Channel>,
}

enum Rows<'a> {
    Stream {
        kind: StreamKind,
        table: TableView<'a>,
        /// Wheel angles for viewers, where wheels are counts and a turn is known.
        joints: Option<(Channel, f64)>,
    },
    Links(&'a Links),
    RoundTrips(&'a RoundTrips),
}

impl<'a> Source<'a> {
    fn stream<W: Write>(
        bag: &mut BagWriter<W>,
        robot: &Robot,
        kind: StreamKind,
        table: TableView<'a>,
    ) -> Result<Self> {
        let (message_type, name) = standard(kind, &table);
        let carries = carries(
            format!("{}/{}", robot.name, kind.name()),
            table.columns.iter().map(|(name, _)| *name),
            table.unknown,
        );
        let topic_name = topic(&robot.name, name);
        let (standard, exact) = open(bag, &topic_name, message_type, &carries, holds(&table))?;
        let counts = robot
            .encoder_counts_per_rev
            .filter(|_| name == "encoder_ticks");
        let joints = match counts {
            Some(counts) => {
                let topic = topic(&robot.name, "joint_states");
                let joints =
                    bag.channel(&topic, MessageType::JointState, &carries.view_metadata())?;
                Some((joints, TAU / f64::from(counts)))
            }
            None => None,
        };
        Ok(Self {
            rows_of: Rows::Stream {
                kind,
                table,
                joints,
            },
            standard,
            exact,
        })
    }

    fn links<W: Write>(bag: &mut BagWriter<W>, links: &'a Links) -> Result<Self> {
        let columns = if links.with_velocity { 8 } else { 6 };
        let columns = LINK_COLUMNS.into_iter().skip(1).take(columns);
        let carries = carries("links".to_owned(), columns, &links.unknown);
        let holds = links.unknown.is_empty()
            && links.messages.iter().all(|message| {
                is_whole_ns(message.t_sent_s) && message.t_received_s.is_none_or(is_whole_ns)
            });
        let kind = MessageType::PositionMessage;
        let (standard, exact) = open(bag, topics::LINKS, kind, &carries, holds)?;
        Ok(Self {
            rows_of: Rows::Links(links),
            standard,
            exact,
        })
    }

    fn round_trips<W: Write>(bag: &mut BagWriter<W>, rtt: &'a RoundTrips) -> Result<Self> {
        let carries = carries(
            "rtt".to_owned(),
            ["seq", "rtt_ms"].into_iter(),
            &rtt.unknown,
        );
        let holds = rtt.unknown.is_empty();
        let (standard, exact) = open(bag, topics::RTT, MessageType::RoundTrip, &carries, holds)?;
        Ok(Self {
            rows_of: Rows::RoundTrips(rtt),
            standard,
            exact,
        })
    }

    fn rows(&self) -> usize {
        match &self.rows_of {
            Rows::Stream { table, .. } => table.t_s.len(),
            Rows::Links(links) => links.messages.len(),
            Rows::RoundTrips(rtt) => rtt.seq.len(),
        }
    }

    /// The time of a row (ns). Round trips have none: their number stands for it.
    fn t_ns(&self, row: usize) -> i64 {
        match &self.rows_of {
            Rows::Stream { table, .. } => ns_from_s(at(table.t_s, row)),
            Rows::Links(links) => ns_from_s(links.messages.get(row).map_or(0.0, |m| m.t_sent_s)),
            Rows::RoundTrips(_) => i64::try_from(row).unwrap_or(i64::MAX),
        }
    }

    fn write<W: Write>(&self, bag: &mut BagWriter<W>, t_ns: i64, row: usize) -> Result<()> {
        match &self.rows_of {
            Rows::Stream {
                kind,
                table,
                joints,
            } => {
                write_standard(bag, self.standard, *kind, table, t_ns, row)?;
                if let Some((channel, rad_per_count)) = joints {
                    let angle = |i| cell(table, i, row) * rad_per_count;
                    bag.write(
                        *channel,
                        t_ns,
                        &joint_state(t_ns, &[angle(0), angle(1)], &[], &[]),
                    )?;
                }
                self.write_exact(bag, t_ns, || stream_row(table, row))
            }
            Rows::Links(links) => {
                let Some(message) = links.messages.get(row) else {
                    return Ok(());
                };
                let record = PositionRecord {
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
                };
                bag.write(self.standard, t_ns, &position_message(&record))?;
                self.write_exact(bag, t_ns, || {
                    let mut texts = vec![message.from.to_string(), message.to.to_string()];
                    texts.extend(unknown_cells(&links.unknown, row));
                    let numbers = vec![
                        message.t_received_s.unwrap_or(f64::NAN),
                        message.x_m,
                        message.y_m,
                        message.yaw_rad,
                        message.v_m_s,
                        message.w_rad_s,
                    ];
                    exact_row(message.t_sent_s, numbers, texts)
                })
            }
            Rows::RoundTrips(rtt) => {
                let seq = rtt.seq.get(row).copied().unwrap_or_default();
                let rtt_ms = at(&rtt.rtt_ms, row);
                bag.write(self.standard, t_ns, &ros::RoundTrip { seq, rtt_ms })?;
                self.write_exact(bag, t_ns, || {
                    let mut texts = vec![seq.to_string()];
                    texts.extend(unknown_cells(&rtt.unknown, row));
                    exact_row(0.0, vec![rtt_ms], texts)
                })
            }
        }
    }

    fn write_exact<W: Write>(
        &self,
        bag: &mut BagWriter<W>,
        t_ns: i64,
        row: impl FnOnce() -> ExactRow,
    ) -> Result<()> {
        match self.exact {
            Some(channel) => bag.write(channel, t_ns, &row()),
            None => Ok(()),
        }
    }
}

type ExactRow = ros::Row<Vec<f64>, Vec<String>>;

fn exact_row(t_s: f64, numbers: Vec<f64>, texts: Vec<String>) -> ExactRow {
    ros::Row {
        t_s,
        numbers,
        texts,
    }
}

fn carries<'a>(
    stream: String,
    columns: impl Iterator<Item = &'a str>,
    unknown: &[UnknownColumn],
) -> Carries {
    Carries {
        stream,
        columns: columns.map(str::to_owned).collect(),
        unknown: unknown.iter().map(|column| column.name.clone()).collect(),
    }
}

/// Opens the channel of the standard messages, and that of the rows where the former do not hold
/// the stream. Only one of the two carries it for slipstream.
fn open<W: Write>(
    bag: &mut BagWriter<W>,
    topic: &str,
    message_type: MessageType,
    carries: &Carries,
    standard_holds: bool,
) -> Result<(Channel, Option<Channel>)> {
    if standard_holds {
        let standard = bag.channel(topic, message_type, &carries.metadata())?;
        return Ok((standard, None));
    }
    let standard = bag.channel(topic, message_type, &carries.view_metadata())?;
    let exact = bag.channel(
        &format!("{topic}/rows"),
        MessageType::Row,
        &carries.metadata(),
    )?;
    Ok((standard, Some(exact)))
}

/// A row to the digit: numbers in the order of their columns, then as text the counts and the
/// cells of unknown columns.
fn stream_row(table: &TableView<'_>, row: usize) -> ExactRow {
    let mut numbers = Vec::with_capacity(table.columns.len());
    let mut texts = Vec::new();
    for (_, cells) in &table.columns {
        match cells {
            CellsView::Numbers(cells) => numbers.push(at(cells, row)),
            CellsView::Counts(cells) => {
                let count = cells.get(row).copied().flatten();
                texts.push(count.map_or_else(String::new, |count| count.to_string()));
            }
        }
    }
    texts.extend(unknown_cells(table.unknown, row));
    exact_row(at(table.t_s, row), numbers, texts)
}

fn unknown_cells(unknown: &[UnknownColumn], row: usize) -> impl Iterator<Item = String> {
    unknown
        .iter()
        .map(move |column| column.cells.get(row).cloned().unwrap_or_default())
}
