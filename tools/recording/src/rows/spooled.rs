//! A recording being read, with its rows in spools.

use slipstream_bag::Result;

use super::all_rows::{AllRows, LinkRows, RobotRows};
use super::cursor::Rows;
use super::disk::Disk;
use super::spool::Spool;
use crate::recording::{LinkMessage, Links, NamePool, Recording, Robot, RoundTrips};
use crate::table::{Cells, StreamKind, Table};

/// A recording whose rows lie in spools.
#[derive(Debug)]
pub(crate) struct SpooledRecording {
    /// The description; its robots have no streams.
    pub(crate) description: Recording,
    /// Where the rows are.
    pub(crate) disk: Disk,
    streams: Vec<SpooledStream>,
    links: Option<SpooledLinks>,
    rtt: Option<Spool>,
}

#[derive(Debug)]
struct SpooledStream {
    /// Index of the robot in the description.
    robot: usize,
    kind: StreamKind,
    spool: Spool,
}

#[derive(Debug)]
struct SpooledLinks {
    spool: Spool,
    with_velocity: bool,
}

impl SpooledRecording {
    /// A recording without rows.
    pub(crate) fn new(description: Recording, disk: Disk) -> Self {
        Self {
            description,
            disk,
            streams: Vec::new(),
            links: None,
            rtt: None,
        }
    }

    /// Adds a robot's stream, and the robot if it is new.
    pub(crate) fn store(&mut self, robot: &str, kind: StreamKind, spool: Spool) {
        let robots = &mut self.description.robots;
        let known = robots.iter().position(|known| known.name == robot);
        let robot = known.unwrap_or_else(|| {
            robots.push(Robot::named(robot));
            robots.len() - 1
        });
        self.streams.push(SpooledStream { robot, kind, spool });
    }

    /// Adds the position messages.
    pub(crate) fn store_links(&mut self, spool: Spool, with_velocity: bool) {
        self.links = Some(SpooledLinks {
            spool,
            with_velocity,
        });
    }

    /// Adds the round trips.
    pub(crate) fn store_round_trips(&mut self, spool: Spool) {
        self.rtt = Some(spool);
    }

    /// The rows. After the last use of them, [`Disk::check`] tells whether all could be read.
    pub(crate) fn rows(&self) -> AllRows<'_> {
        let of_robot = |robot: usize, kind: StreamKind| {
            let is_it = |s: &&SpooledStream| (s.robot, s.kind) == (robot, kind);
            let stream = self.streams.iter().find(is_it)?;
            Some((kind, Rows::of_spool(&stream.spool)))
        };
        let robots = self.description.robots.iter().enumerate();
        let robots = robots.map(|(index, robot)| {
            let kinds = StreamKind::ALL.into_iter();
            RobotRows {
                robot,
                streams: kinds.filter_map(|kind| of_robot(index, kind)).collect(),
            }
        });
        AllRows {
            recording: &self.description,
            robots: robots.collect(),
            links: self.links.as_ref().map(|links| LinkRows {
                rows: Rows::of_spool(&links.spool),
                with_velocity: links.with_velocity,
            }),
            rtt: self.rtt.as_ref().map(Rows::of_spool),
        }
    }

    /// The whole recording in memory.
    ///
    /// # Errors
    /// If the rows could not be written or read.
    pub(crate) fn load(self) -> Result<Recording> {
        self.disk.check()?;
        let mut recording = self.description;
        for stream in self.streams {
            let table = whole(&stream.spool);
            drop(stream.spool);
            if let Some(robot) = recording.robots.get_mut(stream.robot) {
                table.store_in(robot, stream.kind);
            }
        }
        recording.links = self.links.map(|links| Links {
            with_velocity: links.with_velocity,
            ..load_links(&links.spool)
        });
        recording.rtt = self.rtt.map(|spool| load_round_trips(whole(&spool)));
        self.disk.check()?;
        Ok(recording)
    }
}

/// All rows of a stream.
fn whole(spool: &Spool) -> Table {
    let mut table = spool.empty();
    table.reserve(spool.len());
    let mut cursor = Rows::of_spool(spool).cursor();
    while let Some(block) = cursor.next_block() {
        table.extend_from(block);
    }
    table
}

fn load_links(spool: &Spool) -> Links {
    let mut links = Links {
        messages: Vec::with_capacity(spool.len()),
        unknown: spool.empty().unknown,
        ..Links::default()
    };
    let mut names = NamePool::default();
    let mut cursor = Rows::of_spool(spool).cursor();
    while let Some(block) = cursor.next_block() {
        for (row, t_sent_s) in block.t_s.iter().enumerate() {
            let number = |name| block.number_named(name, row);
            links.messages.push(LinkMessage {
                t_sent_s: *t_sent_s,
                t_received_s: Some(number("t_received_s")).filter(|t_s| !t_s.is_nan()),
                from: names.get(block.text_named("from", row)),
                to: names.get(block.text_named("to", row)),
                x_m: number("x_m"),
                y_m: number("y_m"),
                yaw_rad: number("yaw_rad"),
                v_m_s: number("v_m_s"),
                w_rad_s: number("w_rad_s"),
            });
        }
        for (column, of) in links.unknown.iter_mut().zip(&block.unknown) {
            column.cells.extend_from_slice(&of.cells);
        }
    }
    links
}

fn load_round_trips(table: Table) -> RoundTrips {
    let mut trips = RoundTrips {
        unknown: table.unknown,
        ..RoundTrips::default()
    };
    for (_, cells) in table.columns {
        match cells {
            Cells::Counts(seq) => trips.seq = seq.into_iter().flatten().collect(),
            Cells::Numbers(rtt_ms) => trips.rtt_ms = rtt_ms,
            Cells::Texts(_) => {}
        }
    }
    trips
}
