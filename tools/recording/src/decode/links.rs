//! Position messages and round trips assembled from messages that arrive one by one.

use slipstream_bag::ros::cdr::decode;
use slipstream_bag::ros::messages as ros;
use slipstream_bag::ros::time::s_from_ns;
use slipstream_bag::{Undecodable, VisitResult};

use crate::recording::UnknownColumn;
use crate::rows::{Disk, Spool, sorted_by_time};
use crate::table::{Cells, OutOfRange, Table, is_time};

/// Position messages being collected.
#[derive(Debug)]
pub(crate) struct LinksBuilder {
    spool: Spool,
    with_velocity: bool,
    out_of_range: OutOfRange,
}

/// One position message.
struct PositionMessage {
    t_sent_s: f64,
    from: String,
    to: String,
    /// Time of arrival (s; NaN if lost), x, y, yaw, forward speed, yaw rate.
    numbers: [f64; 6],
    /// Cells of the unknown columns.
    unknown: Vec<String>,
}

impl LinksBuilder {
    /// No messages yet, with these unknown columns.
    pub(crate) fn new(disk: &Disk, with_velocity: bool, unknown: &[String]) -> Self {
        Self {
            spool: Spool::new(disk, Table::of_links(&empty_columns(unknown))),
            with_velocity,
            out_of_range: OutOfRange::default(),
        }
    }

    /// Appends a position message.
    pub(crate) fn push_message(&mut self, data: &[u8]) -> VisitResult {
        let message: ros::PositionMessage<String> = decode(data).map_err(|_| Undecodable)?;
        let arrived = message.fate == 0;
        let received_s = arrived.then(|| s_from_ns(message.t_received_ns));
        let unknown = vec![String::new(); self.spool.tail().unknown.len()];
        self.push(PositionMessage {
            t_sent_s: s_from_ns(message.t_sent_ns),
            from: message.sender,
            to: message.receiver,
            numbers: [
                received_s.unwrap_or(f64::NAN),
                message.x_m,
                message.y_m,
                message.yaw_rad,
                message.v_m_s,
                message.w_rad_s,
            ],
            unknown,
        });
        Ok(())
    }

    /// Appends a message from a lossless row.
    pub(crate) fn push_row(&mut self, data: &[u8]) -> VisitResult {
        let row: ros::Row<Vec<f64>, Vec<String>> = decode(data).map_err(|_| Undecodable)?;
        let Ok(numbers) = row.numbers.try_into() else {
            return Err(Undecodable);
        };
        let mut texts = row.texts.into_iter();
        let (Some(from), Some(to)) = (texts.next(), texts.next()) else {
            return Err(Undecodable);
        };
        if !is_time(row.t_s) || texts.len() != self.spool.tail().unknown.len() {
            return Err(Undecodable);
        }
        self.push(PositionMessage {
            t_sent_s: row.t_s,
            from,
            to,
            numbers,
            unknown: texts.collect(),
        });
        Ok(())
    }

    fn push(&mut self, message: PositionMessage) {
        let table = self.spool.tail();
        table.t_s.push(message.t_sent_s);
        let mut numbers = message.numbers.into_iter();
        let mut names = [message.from, message.to].into_iter();
        for (name, cells) in &mut table.columns {
            match cells {
                Cells::Numbers(cells) => {
                    let number = numbers.next().unwrap_or(f64::NAN);
                    cells.push(self.out_of_range.cell(name, number));
                }
                Cells::Texts(cells) => cells.extend(names.next()),
                Cells::Counts(_) => {}
            }
        }
        for (column, cell) in table.unknown.iter_mut().zip(message.unknown) {
            column.cells.push(cell);
        }
        self.spool.end_row();
    }

    /// The messages in the order of sending, and whether they contain velocities. (A run writes a
    /// message once its delivery status is known.)
    pub(crate) fn finish(mut self, warnings: &mut Vec<String>) -> (Spool, bool) {
        self.pass_on(warnings, &Disk::default())
    }

    /// As [`finish`](Self::finish), with the messages so far; those that follow go to another disk.
    pub(crate) fn pass_on(&mut self, warnings: &mut Vec<String>, next: &Disk) -> (Spool, bool) {
        std::mem::take(&mut self.out_of_range).warn("links", warnings);
        (sorted_by_time(self.spool.take(next)), self.with_velocity)
    }
}

/// Round trips being collected.
#[derive(Debug)]
pub(crate) struct RoundTripsBuilder {
    spool: Spool,
    out_of_range: OutOfRange,
}

impl RoundTripsBuilder {
    /// No round trips yet, with these unknown columns.
    pub(crate) fn new(disk: &Disk, unknown: &[String]) -> Self {
        let empty = Table::of_round_trips(&empty_columns(unknown));
        Self {
            spool: Spool::new(disk, empty),
            out_of_range: OutOfRange::default(),
        }
    }

    /// Appends a round trip.
    pub(crate) fn push_message(&mut self, data: &[u8]) -> VisitResult {
        let trip: ros::RoundTrip = decode(data).map_err(|_| Undecodable)?;
        let unknown = vec![String::new(); self.spool.tail().unknown.len()];
        self.push(trip.seq, trip.rtt_ms, unknown);
        Ok(())
    }

    /// Appends a round trip from a lossless row.
    pub(crate) fn push_row(&mut self, data: &[u8]) -> VisitResult {
        let row: ros::Row<Vec<f64>, Vec<String>> = decode(data).map_err(|_| Undecodable)?;
        let mut texts = row.texts.into_iter();
        let seq = texts.next().and_then(|text| text.parse().ok());
        let (Some(seq), &[rtt_ms]) = (seq, row.numbers.as_slice()) else {
            return Err(Undecodable);
        };
        if texts.len() != self.spool.tail().unknown.len() {
            return Err(Undecodable);
        }
        self.push(seq, rtt_ms, texts.collect());
        Ok(())
    }

    fn push(&mut self, seq: i64, rtt_ms: f64, unknown: Vec<String>) {
        let table = self.spool.tail();
        table.push_round_trip(seq, self.out_of_range.cell("rtt_ms", rtt_ms));
        for (column, cell) in table.unknown.iter_mut().zip(unknown) {
            column.cells.push(cell);
        }
        self.spool.end_row();
    }

    /// The round trips in file order.
    pub(crate) fn finish(mut self, warnings: &mut Vec<String>) -> Spool {
        self.pass_on(warnings, &Disk::default())
    }

    /// As [`finish`](Self::finish), with the round trips so far; those that follow go to another disk.
    pub(crate) fn pass_on(&mut self, warnings: &mut Vec<String>, next: &Disk) -> Spool {
        std::mem::take(&mut self.out_of_range).warn("rtt", warnings);
        self.spool.take(next)
    }
}

fn empty_columns(names: &[String]) -> Vec<UnknownColumn> {
    names.iter().map(UnknownColumn::named).collect()
}
